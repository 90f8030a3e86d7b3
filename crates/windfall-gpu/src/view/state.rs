//! What one view of a forest keeps on the GPU.

use crate::base::constants::{CASCADES, DRAW_WORDS, VIEW_TALLIES};
use crate::base::layouts::{self, Layouts};
use crate::base::shared::{CullFrame, Frame, LooseLeaf};
use crate::scene::falls::{Bin, zeros};
use crate::scene::forest::{Forest, ForestBuffers};
use crate::view::camera::ViewError;
use crate::view::cascades::{self, Cascade, Shadows};
use crate::view::description::View;
use crate::view::grass::ViewGrass;
use crate::view::ground::GroundSquares;
use crate::view::light::Light;
use crate::view::lists::TreeLists;
use crate::view::quads::HangingQuads;
use crate::view::shadow_turns::ShadowTurns;
use crate::view::sky::SkyState;
use glam::Mat4;
use wgpu::util::DeviceExt;

/// Most leaves on the twigs that are drawn as quads, 64 bytes each. Leaves beyond it use their full geometry.
const MOST_QUADS: u32 = 1 << 20;

/// One view of one forest: a camera of a split screen, an eye of a headset, a reflection, a shadow map.
///
/// Owns everything that the view needs: several views of a forest, and views of several forests, may be recorded
/// into one submission. The same view twice in one submission is a mistake: the second overwrites the first.
pub struct ViewState {
    pub(crate) device: wgpu::Device,
    forest: u64,
    structure: u64,
    /// What the groups were made of.
    bound: Option<Bound>,
    placeholders: Placeholders,
    pub(crate) frame: FrameGroup,
    pub(crate) shadow_frames: Vec<FrameGroup>,
    pub(crate) shadows: Option<Shadows>,
    pub(crate) shadow_turns: ShadowTurns,
    /// The sky's own tables: where Windfall's sky is drawn or lights.
    pub(crate) sky: Option<SkyState>,
    pub(crate) buffers: Option<ViewBuffers>,
    /// The ground that is drawn.
    pub(crate) ground: GroundSquares,
    /// The grass, once some is drawn.
    pub(crate) grass: Option<ViewGrass>,
    /// What was prepared last.
    pub(crate) prepared: Option<Prepared>,
    /// A pyramid in which nothing is hidden.
    pub(crate) open_pyramid: wgpu::BindGroup,
}

/// What of a view depends on the forest's structure.
pub(crate) struct ViewBuffers {
    pub lists: TreeLists,
    pub quads: Option<HangingQuads>,
    pub loose: LooseView,
}

/// What was prepared.
#[derive(Clone)]
pub(crate) struct Prepared {
    pub view: View,
    pub cull: CullFrame,
    /// The cascades, and which of them this frame draws.
    pub cascades: Option<([Cascade; cascades::CASCADES], [bool; cascades::CASCADES])>,
}

/// The loose leaves that a view draws.
pub(crate) struct LooseView {
    /// The leaves by bin: full ones from its first slot on, small ones from its end down.
    pub drawn: wgpu::Buffer,
    /// Tallies, indirect arguments, levels of streams.
    pub counters: wgpu::Buffer,
    pub group: wgpu::BindGroup,
    /// Indirect arguments of the pass that gathers.
    pub indirect: wgpu::Buffer,
    bins: u64,
}

impl LooseView {
    fn new(
        device: &wgpu::Device,
        layouts: &Layouts,
        buffers: &ForestBuffers,
        lists: &TreeLists,
    ) -> Self {
        let loose = &buffers.loose;
        let slots = u64::from(loose.streams.slot_count);
        let drawn = zeros(
            device,
            "loose leaves",
            slots * size_of::<LooseLeaf>() as u64,
            wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_SRC,
        );
        let counters = zeros(
            device,
            "leaves of a view",
            loose.view_words * 4,
            wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_SRC,
        );
        let group = layouts::group(
            device,
            "loose leaves of a view",
            &layouts.gather,
            &[
                loose.uniform.as_entire_binding(),
                lists.uniform.as_entire_binding(),
                loose.stream_buffer.as_entire_binding(),
                loose.list_buffer.as_entire_binding(),
                buffers.model_buffer.as_entire_binding(),
                loose.posed.as_entire_binding(),
                loose.work.as_entire_binding(),
                drawn.as_entire_binding(),
                counters.as_entire_binding(),
            ],
        );
        // Groups and rows as counted by the shader, 1.
        let indirect = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("groups of leaves to gather"),
            contents: bytemuck::cast_slice(&[0u32, 0, 1]),
            usage: wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST,
        });
        Self { drawn, counters, group, indirect, bins: loose.streams.bins.len() as u64 }
    }

    /// Copies how many groups there are to gather from to the indirect arguments.
    pub fn copy_count(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.copy_buffer_to_buffer(&self.counters, 12, &self.indirect, 0, 8);
    }

    /// Where the draw of a bin has its indirect arguments, bytes; `small` for its leaves of a few pixels.
    pub fn arguments_of(&self, bin: usize, small: bool) -> u64 {
        let bin = bin as u64 + if small { self.bins } else { 0 };
        (u64::from(VIEW_TALLIES) + u64::from(DRAW_WORDS) * bin) * 4
    }

    /// The leaves of a bin.
    pub fn leaves_of(&self, bin: &Bin) -> wgpu::BufferSlice<'_> {
        let size = size_of::<LooseLeaf>() as u64;
        let first = u64::from(bin.first) * size;
        self.drawn.slice(first..first + u64::from(bin.count) * size)
    }
}

/// The uniforms of one camera, and the group that has them.
pub(crate) struct FrameGroup {
    pub buffer: wgpu::Buffer,
    pub group: wgpu::BindGroup,
}

/// What is bound with the uniforms.
pub(crate) struct FrameResources<'a> {
    pub maps: &'a wgpu::TextureView,
    pub shadow_sampler: &'a wgpu::Sampler,
    pub sky_table: &'a wgpu::TextureView,
    pub sky_picture: &'a wgpu::TextureView,
    pub sky_sampler: &'a wgpu::Sampler,
    pub scripted: &'a wgpu::Buffer,
}

/// A buffer for the uniforms of a frame.
pub(crate) fn frame_buffer(device: &wgpu::Device) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("frame"),
        size: size_of::<Frame>() as u64,
        usage: wgpu::BufferUsages::UNIFORM
            | wgpu::BufferUsages::COPY_DST
            | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

/// The group of a frame.
pub(crate) fn frame_group(
    device: &wgpu::Device,
    layouts: &Layouts,
    buffer: &wgpu::Buffer,
    with: &FrameResources<'_>,
) -> wgpu::BindGroup {
    layouts::group(
        device,
        "frame",
        &layouts.frame,
        &[
            buffer.as_entire_binding(),
            wgpu::BindingResource::TextureView(with.maps),
            wgpu::BindingResource::Sampler(with.shadow_sampler),
            wgpu::BindingResource::TextureView(with.sky_table),
            wgpu::BindingResource::TextureView(with.sky_picture),
            wgpu::BindingResource::Sampler(with.sky_sampler),
            with.scripted.as_entire_binding(),
            wgpu::BindingResource::TextureView(&layouts.noise.view),
            wgpu::BindingResource::Sampler(&layouts.noise.sampler),
        ],
    )
}

/// Stands in for an empty buffer.
pub(crate) struct Placeholders {
    /// A shadow map without a shadow.
    pub maps: wgpu::TextureView,
    /// A black sky.
    pub sky: wgpu::TextureView,
    pub sky_sampler: wgpu::Sampler,
    /// Comparison samplers for depth that is 0, and 1, nearest to the sun.
    pub shadow_samplers: [wgpu::Sampler; 2],
    pub scripted: wgpu::Buffer,
}

impl Placeholders {
    pub fn new(device: &wgpu::Device) -> Self {
        let texture = |label, format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        let maps = texture(
            "no shadow maps",
            wgpu::TextureFormat::Depth32Float,
            wgpu::TextureUsages::RENDER_ATTACHMENT,
        );
        let sky =
            texture("no sky", wgpu::TextureFormat::Rgba16Float, wgpu::TextureUsages::COPY_DST);
        let shadow_sampler = |compare| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("shadow"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                compare: Some(compare),
                ..Default::default()
            })
        };
        Self {
            maps: maps.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            }),
            sky: sky.create_view(&wgpu::TextureViewDescriptor::default()),
            sky_sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("sky"),
                address_mode_u: wgpu::AddressMode::Repeat,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            shadow_samplers: [
                wgpu::CompareFunction::LessEqual,
                wgpu::CompareFunction::GreaterEqual,
            ]
            .map(shadow_sampler),
            scripted: zeros(device, "no scripted detaches", 32, wgpu::BufferUsages::empty()),
        }
    }

    pub fn resources(&self) -> FrameResources<'_> {
        FrameResources {
            maps: &self.maps,
            shadow_sampler: &self.shadow_samplers[0],
            sky_table: &self.sky,
            sky_picture: &self.sky,
            sky_sampler: &self.sky_sampler,
            scripted: &self.scripted,
        }
    }
}

/// What a view's groups were made of.
#[derive(PartialEq)]
struct Bound {
    structure: u64,
    host_maps: Option<(wgpu::TextureView, bool)>,
    sky_picture: Option<wgpu::TextureView>,
}

impl ViewState {
    /// A view of a forest; `shadows` is whether it has shadow maps of its own.
    pub(crate) fn new(forest: &Forest, shadows: bool) -> Self {
        let device = &forest.device;
        let layouts = &forest.layouts;
        let placeholders = Placeholders::new(device);
        let group = || {
            let buffer = frame_buffer(device);
            FrameGroup {
                group: frame_group(device, layouts, &buffer, &placeholders.resources()),
                buffer,
            }
        };
        let cascades = if shadows { CASCADES } else { 0 };
        let identity = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("no pyramid's clip space"),
            contents: bytemuck::bytes_of(&Mat4::IDENTITY),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let nothing = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("no pyramid"),
            size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let nothing = nothing.create_view(&wgpu::TextureViewDescriptor::default());
        Self {
            frame: group(),
            shadow_frames: (0..cascades).map(|_| group()).collect(),
            shadows: shadows.then(|| Shadows::new(device)),
            shadow_turns: ShadowTurns::default(),
            sky: None,
            bound: None,
            forest: forest.id(),
            structure: 0,
            buffers: None,
            ground: GroundSquares::new(device),
            grass: None,
            prepared: None,
            open_pyramid: layouts::group(
                device,
                "no pyramid",
                &layouts.pyramid,
                &[wgpu::BindingResource::TextureView(&nothing), identity.as_entire_binding()],
            ),
            placeholders,
            device: device.clone(),
        }
    }

    /// Whether what was prepared is of this forest, and of all that it has now.
    pub(crate) fn check(&self, forest: &Forest) -> Result<(), ViewError> {
        if forest.id() != self.forest {
            return Err(ViewError::OtherForest);
        }
        if self.buffers.is_some() && self.structure != forest.structure() {
            return Err(ViewError::NotPrepared);
        }
        Ok(())
    }

    /// Makes what the forest has outgrown anew.
    pub(crate) fn fit(&mut self, forest: &Forest, view: &View) -> Result<(), ViewError> {
        if forest.id() != self.forest {
            return Err(ViewError::OtherForest);
        }
        let buffers = forest.buffers().ok_or(ViewError::NotAdvanced)?;
        let device = &self.device;
        let layouts = &forest.layouts;
        if self.structure != forest.structure() || self.buffers.is_none() {
            let most = device.limits().max_storage_buffer_binding_size;
            let bytes = buffers.loose.view_words * 4;
            if bytes > most {
                return Err(ViewError::TooLarge { bytes, most });
            }
            let lists = TreeLists::new(device, layouts, buffers);
            self.buffers = Some(ViewBuffers {
                quads: HangingQuads::new(device, layouts, buffers, &lists, MOST_QUADS),
                loose: LooseView::new(device, layouts, buffers, &lists),
                lists,
            });
            self.structure = forest.structure();
        }
        let host = match &view.light {
            Light::Host(light) => light.shadow.as_ref(),
            Light::Sky(..) => None,
        };
        let sky_picture = match &view.light {
            Light::Sky(_, Some(map)) => Some(map.view.clone()),
            _ => None,
        };
        if matches!(view.light, Light::Sky(..)) && self.sky.is_none() {
            self.sky = Some(SkyState::new(device, layouts));
            self.bound = None;
        }
        let bound = Bound {
            structure: self.structure,
            host_maps: host.map(|shadow| (shadow.view.clone(), shadow.reversed)),
            sky_picture,
        };
        if self.bound.as_ref() == Some(&bound) {
            return Ok(());
        }
        let own = self.shadows.as_ref().map(|shadows| &shadows.view);
        let placeholders = &self.placeholders;
        let (maps, reversed) = match &bound.host_maps {
            Some((view, reversed)) => (view, *reversed),
            None => (own.unwrap_or(&placeholders.maps), false),
        };
        let resources = FrameResources {
            maps,
            shadow_sampler: &placeholders.shadow_samplers[usize::from(reversed)],
            sky_table: self.sky.as_ref().map_or(&placeholders.sky, |sky| &sky.table),
            sky_picture: bound.sky_picture.as_ref().unwrap_or(&placeholders.sky),
            scripted: &buffers.scripted,
            ..placeholders.resources()
        };
        self.frame.group = frame_group(device, layouts, &self.frame.buffer, &resources);
        // A map cannot be looked up while it is drawn.
        let resources = FrameResources {
            maps: &placeholders.maps,
            shadow_sampler: &placeholders.shadow_samplers[0],
            ..resources
        };
        for frame in &mut self.shadow_frames {
            frame.group = frame_group(device, layouts, &frame.buffer, &resources);
        }
        self.bound = Some(bound);
        Ok(())
    }

    /// Bytes of GPU memory of the view's lists, without its shadow maps and targets.
    pub fn bytes(&self) -> u64 {
        let Some(ViewBuffers { lists, loose, quads }) = &self.buffers else { return 0 };
        lists.placed.size()
            + lists.arguments.size()
            + loose.drawn.size()
            + loose.counters.size()
            + quads.as_ref().map_or(0, HangingQuads::bytes)
            + self.grass.as_ref().map_or(0, |_| ViewGrass::BYTES)
    }
}
