//! The grass about a camera.

use crate::base::layouts::{self, Layouts};

/// Cells along a side of the square about the camera, each with a tuft.
pub const SIDE: u32 = 128;
/// Such squares, the second of wider cells.
const RINGS: u32 = 2;
/// Blades of a tuft.
pub const BLADES: u32 = 5;
/// Most tufts.
pub const TUFTS: u32 = RINGS * SIDE * SIDE;
/// Bytes of `Tuft` in `tuft.wgsl`.
const TUFT_BYTES: u64 = 32;

/// The grass of one view.
pub struct ViewGrass {
    /// Arguments of the draw, then the number of tufts.
    pub found: wgpu::Buffer,
    /// For the pass that finds it, and for the one that draws it.
    pub find_group: wgpu::BindGroup,
    pub draw_group: wgpu::BindGroup,
}

impl ViewGrass {
    /// What its buffers hold.
    pub const BYTES: u64 = TUFTS as u64 * (TUFT_BYTES + 4 * BLADES as u64);

    pub fn new(device: &wgpu::Device, layouts: &Layouts) -> Self {
        let buffer = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: usage | wgpu::BufferUsages::STORAGE,
                mapped_at_creation: false,
            })
        };
        let none = wgpu::BufferUsages::empty();
        let tufts = buffer("tufts", u64::from(TUFTS) * TUFT_BYTES, none);
        let blades = buffer("blades", u64::from(TUFTS * BLADES) * 4, none);
        let found = buffer(
            "grass that was found",
            5 * 4,
            wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST,
        );
        let all = [&tufts, &blades, &found].map(wgpu::Buffer::as_entire_binding);
        Self {
            find_group: layouts::group(device, "find grass", &layouts.find_grass, &all),
            draw_group: layouts::group(device, "grass", &layouts.grass, &all[..2]),
            found,
        }
    }
}
