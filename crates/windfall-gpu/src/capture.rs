//! A picture back from the GPU, without blocking.

use std::sync::{Arc, Mutex};

/// A copy of a texture on its way to the CPU.
///
/// ```text
/// let capture = Capture::encode(&device, &mut encoder, &texture);
/// queue.submit([encoder.finish()]);
/// capture.map();
/// device.poll(...);          // or the host's own loop; in a browser nothing is needed
/// let rgba = capture.take(); // Some(...) once the GPU is done
/// ```
pub struct Capture {
    buffer: wgpu::Buffer,
    row_bytes: u32,
    padded_row_bytes: u32,
    state: Arc<Mutex<Option<Result<(), wgpu::BufferAsyncError>>>>,
}

impl Capture {
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
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("capture"),
            size: u64::from(padded_row_bytes) * u64::from(texture.height()),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded_row_bytes),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() },
        );
        Self { buffer, row_bytes, padded_row_bytes, state: Arc::default() }
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

    /// The rows of the texture without padding, once they are here; an error if the device was
    /// lost.
    ///
    /// # Errors
    ///
    /// [`wgpu::BufferAsyncError`] if the buffer could not be mapped.
    pub fn take(&self) -> Option<Result<Vec<u8>, wgpu::BufferAsyncError>> {
        let result = self.state.lock().ok()?.take()?;
        Some(result.map(|()| {
            let mapped = self.buffer.slice(..).get_mapped_range();
            mapped
                .chunks_exact(self.padded_row_bytes as usize)
                .flat_map(|row| &row[..self.row_bytes as usize])
                .copied()
                .collect()
        }))
    }
}
