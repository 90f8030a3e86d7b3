//! The renderer: pipelines for a device, made once, the same for every forest and view.

use crate::base::layouts::Layouts;
use crate::base::pipeline::{Depth, Target};
use crate::base::wgsl::{Settings, Shaders};
use crate::pass::cull::Cull;
use crate::pass::falls::Falls;
use crate::pass::gather::{Gather, LooseLeaves};
use crate::pass::grass::Grass;
use crate::pass::ground::Ground;
use crate::pass::hiz::HiZ;
use crate::pass::leaves::Leaves;
use crate::pass::quads::{DrawQuads, Quads};
use crate::pass::sky::SkyDome;
use crate::pass::sky_light::SkyLightPass;
use crate::pass::tone_map::ToneMap;
use crate::pass::wood::Wood;
use crate::scene::forest::{Forest, MomentGroup};
use crate::view::camera::ViewError;
use crate::view::cascades;
use crate::view::state::{Placeholders, ViewState, frame_buffer, frame_group};
use crate::view::targets::{DEPTH, PictureTargets, RADIANCE, SAMPLES};
use std::sync::OnceLock;
use wgpu::{WasmNotSend, WasmNotSync};

/// What a renderer draws beside foliage: pipelines are built for these alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[expect(clippy::struct_excessive_bools, reason = "layers that are there or not, each by itself")]
pub struct Layers {
    /// Windfall's own shadow maps of the sun.
    pub shadows: bool,
    /// The terrain.
    pub ground: bool,
    /// Grass about the camera.
    pub grass: bool,
    /// The sky behind everything.
    pub sky: bool,
    /// Occlusion culling and tone mapping: whole pictures ([`Renderer::render`]).
    pub picture: bool,
}

impl Layers {
    /// Foliage alone: wood and leaves, on their twigs, in the air and on the ground.
    pub const FOLIAGE: Self =
        Self { shadows: false, ground: false, grass: false, sky: false, picture: false };
    /// Everything.
    pub const PICTURE: Self =
        Self { shadows: true, ground: true, grass: true, sky: true, picture: true };
}

/// What a renderer draws into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Format of the colours. Foliage writes linear radiance: an sRGB format, or one of floats.
    pub color_format: wgpu::TextureFormat,
    /// Format of the depth.
    pub depth_format: wgpu::TextureFormat,
    /// Whether depth is 1 near and 0 far. A whole picture ([`Layers::picture`]) has depth of its own, always so.
    pub reversed_depth: bool,
    /// Samples of a pixel, 1 or 4.
    pub samples: u32,
    /// Depth that [`Renderer::draw_depth`] draws into, of the host's shadow map or depth pre-pass; `None`: it is
    /// not wanted.
    pub depth_only: Option<DepthOnly>,
    /// What is drawn beside foliage.
    pub layers: Layers,
}

/// A target of depth alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DepthOnly {
    /// Its format.
    pub format: wgpu::TextureFormat,
    /// Whether depth is 1 near and 0 far.
    pub reversed: bool,
    /// Samples of a pixel, 1 or 4.
    pub samples: u32,
    /// Whether leaves before the near plane are drawn on it: for shadow maps that end there, while trees farther towards
    /// the sun cast shadows too. Needs [`wgpu::Features::DEPTH_CLIP_CONTROL`].
    pub unclipped: bool,
}

impl Options {
    /// Whole pictures of a format, which should be an sRGB format: the output is linear and the hardware
    /// encodes it.
    pub fn picture(format: wgpu::TextureFormat) -> Self {
        Self {
            color_format: format,
            depth_format: DEPTH,
            reversed_depth: true,
            samples: SAMPLES,
            depth_only: None,
            layers: Layers::PICTURE,
        }
    }

    /// Foliage alone, in a host's pass with reversed depth and without multisampling.
    pub fn foliage(color_format: wgpu::TextureFormat, depth_format: wgpu::TextureFormat) -> Self {
        Self {
            color_format,
            depth_format,
            reversed_depth: true,
            samples: 1,
            depth_only: None,
            layers: Layers::FOLIAGE,
        }
    }
}

/// A part of the building of a renderer, for [`Renderer::new_with`].
#[cfg(not(target_arch = "wasm32"))]
pub type Job<'a> = Box<dyn FnOnce() + Send + 'a>;

/// A part of the building of a renderer, for [`Renderer::new_with`]. In browsers a device stays on its thread.
#[cfg(target_arch = "wasm32")]
pub type Job<'a> = Box<dyn FnOnce() + 'a>;

/// What a job makes.
struct Built<T>(OnceLock<T>);

impl<T: WasmNotSend + WasmNotSync> Built<T> {
    fn new() -> Self {
        Self(OnceLock::new())
    }

    /// The job that makes it with `make`.
    fn job<'a>(&'a self, make: impl FnOnce() -> T + WasmNotSend + 'a) -> Job<'a> {
        Box::new(move || {
            let _ = self.0.set(make());
        })
    }

    fn take(self) -> T {
        self.0.into_inner().expect("every job was run")
    }
}

/// Why there is no renderer for such options.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RendererError {
    /// Pixels have one sample or four.
    #[error("{samples} samples a pixel; foliage is drawn with 1 or 4")]
    Samples {
        /// What was asked for.
        samples: u32,
    },
    /// The format has no colours that can be drawn, or no depth.
    #[error("{format:?} is no format of {what}")]
    Format {
        /// The format.
        format: wgpu::TextureFormat,
        /// Colours, those of a sky, which blend, or depth.
        what: &'static str,
    },
    /// [`DepthOnly::unclipped`] on a device without the feature that it needs.
    #[error("depth beyond the near plane is kept by devices with DEPTH_CLIP_CONTROL alone")]
    Unclipped,
    /// The device cannot do what every forest needs.
    #[error(transparent)]
    Device(#[from] crate::base::requirements::Unsupported),
}

/// Pipelines that draw foliage with colours.
pub(crate) struct ColorPasses {
    pub wood: Wood,
    pub leaves: Leaves,
    pub loose: LooseLeaves,
    pub quads: DrawQuads,
}

/// Pipelines that draw depth of foliage alone.
pub(crate) struct DepthPasses {
    pub wood: Wood,
    pub leaves: Leaves,
    pub loose: LooseLeaves,
    pub quads: DrawQuads,
}

impl DepthPasses {
    fn new(shaders: &Shaders<'_>, layouts: &Layouts, target: Target) -> Self {
        Self {
            wood: Wood::new(shaders, layouts, target),
            leaves: Leaves::new(shaders, layouts, target),
            loose: LooseLeaves::new(shaders, layouts, target),
            quads: DrawQuads::new(shaders, layouts, target),
        }
    }
}

/// What whole pictures need more.
pub(crate) struct PicturePasses {
    pub hiz: HiZ,
    pub tone_map: ToneMap,
}

/// Pipelines for a device and a kind of target: made once, the same for every forest and view.
///
/// The parts of a frame, in order: [`Renderer::advance`] once a frame and forest, [`Renderer::prepare`] for each
/// view, [`Renderer::draw`] in the host's render pass. [`Renderer::render`] is a whole picture of them.
pub struct Renderer {
    pub(crate) device: wgpu::Device,
    pub(crate) layouts: Layouts,
    options: Options,
    pub(crate) falls: Falls,
    pub(crate) cull: Cull,
    pub(crate) gather: Gather,
    pub(crate) quads: Quads,
    pub(crate) color: ColorPasses,
    pub(crate) shadows: Option<DepthPasses>,
    pub(crate) depth_only: Option<DepthPasses>,
    pub(crate) ground: Option<Ground>,
    pub(crate) grass: Option<Grass>,
    pub(crate) sky: Option<SkyDome>,
    pub(crate) sky_light: SkyLightPass,
    pub(crate) picture: Option<PicturePasses>,
    placeholders: Placeholders,
}

impl Renderer {
    /// Builds the pipelines for `options`. It takes a second or two: at load time, never inside a frame.
    ///
    /// # Errors
    ///
    /// [`RendererError`]: formats and samples that cannot be drawn, a device that cannot do it.
    pub fn new(device: &wgpu::Device, options: &Options) -> Result<Self, RendererError> {
        Self::new_with(device, options, &|jobs| jobs.into_iter().for_each(|job| job()))
    }

    /// [`Renderer::new`] on threads of the host: `run` runs the jobs, in any order and at the same time if it can, and
    /// returns once all have run. On two cores that takes half of the time; the renderer is the same.
    ///
    /// # Errors
    ///
    /// Those of [`Renderer::new`].
    ///
    /// # Panics
    ///
    /// If `run` does not run every job.
    pub fn new_with(
        device: &wgpu::Device,
        options: &Options,
        run: &dyn Fn(Vec<Job<'_>>),
    ) -> Result<Self, RendererError> {
        crate::base::requirements::check_device(device)?;
        let samples = |samples| match samples {
            1 | 4 => Ok(()),
            _ => Err(RendererError::Samples { samples }),
        };
        let color = |format: wgpu::TextureFormat| {
            let fits = format.has_color_aspect() && !format.is_compressed();
            if fits { Ok(()) } else { Err(RendererError::Format { format, what: "colours" }) }
        };
        let depth = |format: wgpu::TextureFormat| {
            let fits = format.has_depth_aspect();
            if fits { Ok(()) } else { Err(RendererError::Format { format, what: "depth" }) }
        };
        samples(options.samples)?;
        color(options.color_format)?;
        depth(options.depth_format)?;
        let blends = options
            .color_format
            .guaranteed_format_features(device.features())
            .flags
            .contains(wgpu::TextureFormatFeatureFlags::BLENDABLE);
        if options.layers.sky && !options.layers.picture && !blends {
            return Err(RendererError::Format {
                format: options.color_format,
                what: "a sky's colours",
            });
        }
        if let Some(only) = options.depth_only {
            samples(only.samples)?;
            depth(only.format)?;
            if only.unclipped && !device.features().contains(wgpu::Features::DEPTH_CLIP_CONTROL) {
                return Err(RendererError::Unclipped);
            }
        }
        let layers = options.layers;
        // A whole picture is drawn as radiance first.
        let target = if layers.picture {
            Target {
                color: Some(RADIANCE),
                blend: false,
                depth: Some(Depth::nearest(DEPTH, true)),
                samples: SAMPLES,
            }
        } else {
            Target {
                color: Some(options.color_format),
                blend: false,
                depth: Some(Depth::nearest(options.depth_format, options.reversed_depth)),
                samples: options.samples,
            }
        };
        let layouts = Layouts::new(device);
        let shaders = Shaders::new(device, Settings { samples: target.samples });
        let (falls, cull, gather, quads) = (Built::new(), Built::new(), Built::new(), Built::new());
        let (wood, leaves, loose, draw_quads) =
            (Built::new(), Built::new(), Built::new(), Built::new());
        let (shadows, depth_only, sky_light) = (Built::new(), Built::new(), Built::new());
        let (ground, grass, sky, picture) =
            (Built::new(), Built::new(), Built::new(), Built::new());
        let (shaders, made) = (&shaders, &layouts);
        // Those that take longest come first.
        run(vec![
            leaves.job(|| Leaves::new(shaders, made, target)),
            shadows
                .job(|| layers.shadows.then(|| DepthPasses::new(shaders, made, cascades::TARGET))),
            depth_only.job(|| {
                options.depth_only.map(|only| {
                    let depth = Depth::nearest(only.format, only.reversed);
                    let depth = Some(Depth { unclipped: only.unclipped, ..depth });
                    let samples = only.samples;
                    DepthPasses::new(
                        shaders,
                        made,
                        Target { color: None, blend: false, depth, samples },
                    )
                })
            }),
            falls.job(|| Falls::new(shaders, made)),
            wood.job(|| Wood::new(shaders, made, target)),
            quads.job(|| Quads::new(shaders, made)),
            loose.job(|| LooseLeaves::new(shaders, made, target)),
            cull.job(|| Cull::new(shaders, made)),
            ground.job(|| layers.ground.then(|| Ground::new(shaders, made, target))),
            sky.job(|| layers.sky.then(|| SkyDome::new(shaders, made, target))),
            grass.job(|| layers.grass.then(|| Grass::new(shaders, made, target))),
            gather.job(|| Gather::new(shaders, made)),
            draw_quads.job(|| DrawQuads::new(shaders, made, target)),
            sky_light.job(|| SkyLightPass::new(shaders, made)),
            picture.job(|| {
                layers.picture.then(|| PicturePasses {
                    hiz: HiZ::new(shaders, made),
                    tone_map: ToneMap::new(shaders, made, options.color_format),
                })
            }),
        ]);
        Ok(Self {
            falls: falls.take(),
            cull: cull.take(),
            gather: gather.take(),
            quads: quads.take(),
            color: ColorPasses {
                wood: wood.take(),
                leaves: leaves.take(),
                loose: loose.take(),
                quads: draw_quads.take(),
            },
            shadows: shadows.take(),
            depth_only: depth_only.take(),
            ground: ground.take(),
            grass: grass.take(),
            sky: sky.take(),
            sky_light: sky_light.take(),
            picture: picture.take(),
            placeholders: Placeholders::new(device),
            options: *options,
            layouts,
            device: device.clone(),
        })
    }

    /// What it was made of.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// What one view of a forest keeps. The forest is of the renderer's device.
    pub fn view(&self, forest: &Forest) -> ViewState {
        ViewState::new(forest, self.options.layers.shadows)
    }

    /// The textures between the passes of whole pictures of `width` by `height` pixels.
    ///
    /// # Errors
    ///
    /// [`ViewError::Empty`] and [`ViewError::TooWide`].
    pub fn targets(&self, width: u32, height: u32) -> Result<PictureTargets, ViewError> {
        PictureTargets::new(&self.device, &self.layouts, width, height)
    }

    /// The uniforms of a forest's moment, for passes that have no view.
    pub(crate) fn moment_group(&self, scripted: &wgpu::Buffer) -> MomentGroup {
        let mut resources = self.placeholders.resources();
        resources.scripted = scripted;
        let buffer = frame_buffer(&self.device);
        MomentGroup { group: frame_group(&self.device, &self.layouts, &buffer, &resources), buffer }
    }
}
