//! The textures between the passes of a whole picture.

use crate::base::layouts::{self, Layouts};
use crate::base::timing::PassTargets;
use crate::view::camera::ViewError;
use crate::view::pyramid::Pyramid;

/// Samples of a pixel of a whole picture.
pub const SAMPLES: u32 = 4;
/// Radiance before tone mapping.
pub const RADIANCE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Depth: 1 at the near plane, 0 at infinity.
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The textures between the passes of a whole picture, for one size.
pub struct PictureTargets {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) depth: wgpu::TextureView,
    pub(crate) pyramid: Pyramid,
    pub(crate) radiance: wgpu::TextureView,
    pub(crate) radiance_group: wgpu::BindGroup,
}

impl PictureTargets {
    /// For pictures of `width` by `height` pixels.
    pub(crate) fn new(
        device: &wgpu::Device,
        layouts: &Layouts,
        width: u32,
        height: u32,
    ) -> Result<Self, ViewError> {
        if width == 0 || height == 0 {
            return Err(ViewError::Empty { width, height });
        }
        let most = device.limits().max_texture_dimension_2d;
        if width > most || height > most {
            return Err(ViewError::TooWide { width, height, most });
        }
        let texture = |label, format| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: SAMPLES,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                    | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let depth = texture("depth", DEPTH);
        let radiance = texture("radiance", RADIANCE);
        Ok(Self {
            width,
            height,
            pyramid: Pyramid::new(device, layouts, &depth, (width, height)),
            depth,
            radiance_group: layouts::group(
                device,
                "radiance",
                &layouts.radiance,
                &[wgpu::BindingResource::TextureView(&radiance)],
            ),
            radiance,
        })
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The pass that draws the scene: from nothing or over what is there. Depth is kept where somebody will
    /// ask for it.
    pub(crate) fn scene<'a>(
        &'a self,
        label: &'a str,
        first: bool,
        keep_depth: bool,
    ) -> PassTargets<'a> {
        let color =
            if first { wgpu::LoadOp::Clear(wgpu::Color::BLACK) } else { wgpu::LoadOp::Load };
        let depth = if first { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
        let store_depth = if keep_depth { wgpu::StoreOp::Store } else { wgpu::StoreOp::Discard };
        PassTargets {
            label,
            color: Some(wgpu::RenderPassColorAttachment {
                view: &self.radiance,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: color, store: wgpu::StoreOp::Store },
            }),
            depth: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load: depth, store: store_depth }),
                stencil_ops: None,
            }),
        }
    }

    /// The pass that writes the picture.
    pub(crate) fn picture(output: &wgpu::TextureView) -> PassTargets<'_> {
        PassTargets {
            label: "tone map",
            color: Some(wgpu::RenderPassColorAttachment {
                view: output,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            }),
            depth: None,
        }
    }
}
