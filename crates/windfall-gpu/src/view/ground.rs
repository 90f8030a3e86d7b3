//! The ground that a camera sees.

use crate::scene::ground::Square;

/// The squares of one view on the GPU.
pub struct GroundSquares {
    pub buffer: wgpu::Buffer,
    pub count: u32,
}

impl GroundSquares {
    /// None.
    pub fn new(device: &wgpu::Device) -> Self {
        Self { buffer: Self::buffer(device, 1024), count: 0 }
    }

    fn buffer(device: &wgpu::Device, squares: u64) -> wgpu::Buffer {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("squares of ground"),
            size: squares * size_of::<Square>() as u64,
            usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// Takes these instead.
    pub fn write(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, squares: &[Square]) {
        let bytes: &[u8] = bytemuck::cast_slice(squares);
        if (bytes.len() as u64) > self.buffer.size() {
            self.buffer = Self::buffer(device, (squares.len() as u64).next_power_of_two());
        }
        queue.write_buffer(&self.buffer, 0, bytes);
        self.count = squares.len() as u32;
    }
}
