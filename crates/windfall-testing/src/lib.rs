//! What Windfall's tests share: a device, and pictures held against references.
//!
//! For `[dev-dependencies]` only. Depends on none of the other crates, so that each of them can
//! use it in its tests.
#![deny(missing_docs)]

mod snapshot;

use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

pub use snapshot::{Mismatch, Snapshots, Tolerance};

/// The first adapter of the machine: one for all tests of a process.
///
/// # Panics
///
/// If there is none.
pub fn adapter() -> wgpu::Adapter {
    static ADAPTER: OnceLock<wgpu::Adapter> = OnceLock::new();
    let open = || {
        let backends = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends,
            ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
        });
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        }))
        .expect(
            "the tests need a graphics adapter; a software one will do: apt-get install \
             mesa-vulkan-drivers",
        )
    };
    ADAPTER.get_or_init(open).clone()
}

/// The first device of the machine, with everything its adapter allows: one for all tests of a process.
///
/// # Panics
///
/// If there is none: a test that cannot draw fails, it does not skip.
pub fn device() -> (wgpu::Device, wgpu::Queue) {
    static DEVICE: OnceLock<(wgpu::Device, wgpu::Queue)> = OnceLock::new();
    let open = || {
        let adapter = adapter();
        request(&adapter, adapter.features() & wgpu::Features::all_webgpu_mask(), adapter.limits())
    };
    DEVICE.get_or_init(open).clone()
}

/// A device as every browser has it: WebGPU's default limits, and no optional feature. A new one for each call.
///
/// # Panics
///
/// If there is none.
pub fn default_device() -> (wgpu::Device, wgpu::Queue) {
    request(&adapter(), wgpu::Features::empty(), wgpu::Limits::default())
}

fn request(
    adapter: &wgpu::Adapter,
    required_features: wgpu::Features,
    required_limits: wgpu::Limits,
) -> (wgpu::Device, wgpu::Queue) {
    pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("windfall tests"),
        required_features,
        required_limits,
        ..Default::default()
    }))
    .expect("the adapter gives a device")
}

/// An empty picture of so many pixels, in sRGB, to draw on and to copy from.
pub fn picture(device: &wgpu::Device, (width, height): (u32, u32)) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// The bytes of a buffer with [`wgpu::BufferUsages::COPY_SRC`], after all that was submitted.
///
/// # Panics
///
/// If the device is lost.
pub fn read(device: &wgpu::Device, queue: &wgpu::Queue, buffer: &wgpu::Buffer) -> Vec<u8> {
    let copy = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("copy"),
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    queue.submit([encoder.finish()]);
    let mapped = Arc::new(OnceLock::new());
    let told = Arc::clone(&mapped);
    copy.slice(..).map_async(wgpu::MapMode::Read, move |result| drop(told.set(result)));
    wait(device, || mapped.get().cloned()).expect("the copy is mapped");
    copy.slice(..).get_mapped_range().to_vec()
}

/// What a read-back gives, as soon as it is there.
///
/// One wait for the device is not enough where tests share it: another thread's wait may have
/// collected this one's callback, and not called it yet.
///
/// # Panics
///
/// If the device is lost, or gives nothing for two minutes.
pub fn wait<T>(device: &wgpu::Device, mut take: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is there");
        if let Some(taken) = take() {
            return taken;
        }
        assert!(start.elapsed() < Duration::from_mins(2), "nothing was read back");
        std::thread::yield_now();
    }
}
