//! Renderers: the pipelines for each kind of target that some camera has. They are built on tasks; until one is ready its
//! cameras show no foliage.

use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;
use bevy::render::renderer::RenderDevice;
use bevy::tasks::{AsyncComputeTaskPool, ComputeTaskPool, Task, block_on};
use windfall::{DepthOnly, Job, Layers, Options, Renderer, RendererError, wgpu};

/// A kind of target: the format and samples of a camera's colours.
pub(crate) type Kind = (TextureFormat, u32);

enum Slot {
    Building(Task<Result<Renderer, RendererError>>),
    Ready(Box<Renderer>),
    Failed,
}

/// The renderers, by kind of target.
#[derive(Resource, Default)]
pub(crate) struct Renderers {
    of: HashMap<Kind, Slot>,
}

/// Format of Bevy's depth and shadow maps.
const DEPTH: TextureFormat = bevy::core_pipeline::core_3d::CORE_3D_DEPTH_FORMAT;

impl Renderers {
    /// Begins to build what is missing.
    pub fn want(&mut self, (format, samples): Kind, device: &RenderDevice) {
        if self.of.contains_key(&(format, samples)) {
            return;
        }
        let device = device.wgpu_device().clone();
        // Casters between the sun and the near plane of a cascade: Bevy draws them on that plane.
        let unclipped = device.features().contains(wgpu::Features::DEPTH_CLIP_CONTROL);
        if !unclipped {
            warn!(
                "trees before a shadow cascade cast no shadows: the device lacks DEPTH_CLIP_CONTROL"
            );
        }
        let options = Options {
            color_format: format,
            depth_format: DEPTH,
            reversed_depth: true,
            samples,
            depth_only: Some(DepthOnly { format: DEPTH, reversed: true, samples: 1, unclipped }),
            layers: Layers::FOLIAGE,
        };
        let build = async move { Renderer::new_with(&device, &options, &on_all_cores) };
        let task = AsyncComputeTaskPool::get().spawn(build);
        self.of.insert((format, samples), Slot::Building(task));
    }

    /// Takes what has been built.
    pub fn poll(&mut self) {
        for (kind, slot) in &mut self.of {
            let Slot::Building(task) = slot else { continue };
            if !task.is_finished() {
                continue;
            }
            *slot = match block_on(task) {
                Ok(renderer) => Slot::Ready(Box::new(renderer)),
                Err(cause) => {
                    let (format, samples) = kind;
                    error!("cameras with {samples} samples of {format:?} show no foliage: {cause}");
                    Slot::Failed
                }
            };
        }
    }

    /// The renderer for a kind of target, once it is there.
    pub fn get(&self, kind: Kind) -> Option<&Renderer> {
        match self.of.get(&kind) {
            Some(Slot::Ready(renderer)) => Some(renderer.as_ref()),
            _ => None,
        }
    }

    /// Any: what is computed of a forest's moment does not depend on targets.
    pub fn any(&self) -> Option<&Renderer> {
        self.of.values().find_map(|slot| match slot {
            Slot::Ready(renderer) => Some(renderer.as_ref()),
            _ => None,
        })
    }

    /// How many are being built.
    pub fn waiting(&self) -> usize {
        self.of.values().filter(|slot| matches!(slot, Slot::Building(_))).count()
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn on_all_cores(jobs: Vec<Job<'_>>) {
    ComputeTaskPool::get().scope(|scope| {
        for job in jobs {
            scope.spawn(async move { job() });
        }
    });
}

#[cfg(target_arch = "wasm32")]
fn on_all_cores(jobs: Vec<Job<'_>>) {
    jobs.into_iter().for_each(|job| job());
}
