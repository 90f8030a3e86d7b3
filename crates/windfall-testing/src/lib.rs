//! What Windfall's tests share: a device, and pictures held against references.
//!
//! For `[dev-dependencies]` only. Depends on none of the other crates, so that each of them can
//! use it in its tests.
#![deny(missing_docs)]

mod snapshot;

pub use snapshot::{Mismatch, Snapshots, Tolerance};

/// The first device of the machine, with everything its adapter allows.
///
/// # Panics
///
/// If there is none: a test that cannot draw fails, it does not skip.
pub fn device() -> (wgpu::Device, wgpu::Queue) {
    let backends = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
    });
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        ..Default::default()
    }))
    .expect(
        "the tests need a graphics adapter; a software one will do: apt-get install \
         mesa-vulkan-drivers",
    );
    pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("windfall tests"),
        required_features: adapter.features() & wgpu::Features::all_webgpu_mask(),
        required_limits: adapter.limits(),
        ..Default::default()
    }))
    .expect("the adapter gives a device")
}
