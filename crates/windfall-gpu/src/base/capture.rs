//! Pictures and counts back from the GPU, without blocking.

use std::sync::{Arc, Mutex};

/// A copy on its way to the CPU.
pub struct Readback {
    /// Where the copy is recorded to.
    pub buffer: wgpu::Buffer,
    state: Arc<Mutex<Option<Result<(), wgpu::BufferAsyncError>>>>,
}

impl Readback {
    /// Room for `size` bytes.
    pub fn new(device: &wgpu::Device, size: u64) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Self { buffer, state: Arc::default() }
    }

    /// Asks for the bytes. To be called once, after the encoder was submitted.
    pub fn map(&self) {
        let state = Arc::clone(&self.state);
        self.buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            if let Ok(mut state) = state.lock() {
                *state = Some(result);
            }
        });
    }

    /// What is read from the bytes, once they are here.
    pub fn take<T>(
        &self,
        read: impl FnOnce(&[u8]) -> T,
    ) -> Option<Result<T, wgpu::BufferAsyncError>> {
        let result = self.state.lock().ok()?.take()?;
        Some(result.map(|()| read(&self.buffer.slice(..).get_mapped_range())))
    }
}

/// A picture on its way to the CPU.
///
/// ```text
/// let capture = Capture::encode(&device, &mut encoder, &texture);
/// queue.submit([encoder.finish()]);
/// capture.map();
/// device.poll(...);          // or the host's own loop; in a browser nothing is needed
/// let rgba = capture.take(); // Some(...) once the GPU is done
/// ```
pub struct Capture {
    readback: Readback,
    row_bytes: u32,
    padded_row_bytes: u32,
}

impl Capture {
    /// A texture to draw a picture into and to copy it from.
    pub fn texture(
        device: &wgpu::Device,
        size: wgpu::Extent3d,
        format: wgpu::TextureFormat,
    ) -> wgpu::Texture {
        device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    /// Records the copy of `texture` (mip 0, layer 0). The texture needs usage `COPY_SRC` and an
    /// uncompressed colour format.
    ///
    /// # Panics
    ///
    /// If the format is compressed or a depth format.
    pub fn encode(
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
    ) -> Self {
        let pixel = texture.format().block_copy_size(None);
        let pixel = pixel.expect("a colour format with one block per pixel");
        let row_bytes = texture.width() * pixel;
        let padded_row_bytes = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let size = u64::from(padded_row_bytes) * u64::from(texture.height());
        let readback = Readback::new(device, size);
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &readback.buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded_row_bytes),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() },
        );
        Self { readback, row_bytes, padded_row_bytes }
    }

    /// Asks for the bytes. To be called once, after the encoder was submitted.
    pub fn map(&self) {
        self.readback.map();
    }

    /// The rows of the texture without padding, once they are here.
    ///
    /// # Errors
    ///
    /// [`wgpu::BufferAsyncError`] if the buffer could not be mapped: the device was lost.
    pub fn take(&self) -> Option<Result<Vec<u8>, wgpu::BufferAsyncError>> {
        self.readback.take(|mapped| {
            mapped
                .chunks_exact(self.padded_row_bytes as usize)
                .flat_map(|row| &row[..self.row_bytes as usize])
                .copied()
                .collect()
        })
    }
}
