//! The frame: its passes in order, and nothing else.

use crate::base::constants::{CASCADES, DebugView, VIEWS, WOOD};
use crate::base::shared::{Frame, SkyUniform};
use crate::base::timing::{TimedPass, Timing};
use crate::renderer::{DepthPasses, Renderer};
use crate::scene::falls::Counter;
use crate::scene::forest::{Forest, ForestBuffers, ForestError, Moment};
use crate::view::camera::ViewError;
use crate::view::cascades::{self, Cascade};
use crate::view::culling::Culling;
use crate::view::description::View;
use crate::view::grass::ViewGrass;
use crate::view::light::Light;
use crate::view::lists::cull_frame;
use crate::view::quality::Quality;
use crate::view::shadow_turns::{ShadowTurns, Shown};
use crate::view::state::{FrameGroup, Prepared, ViewBuffers, ViewState};
use crate::view::targets::PictureTargets;
use bytemuck::Zeroable;
use windfall_core::forest::Frustum;
use windfall_core::simplify::FadeBy;

/// Where a frame is recorded: the host's queue and encoder.
///
/// Uniforms are written through the queue: they count when the host submits next. An encoder that is dropped
/// leaves nothing wrong behind, but for shadow maps that are kept for some frames ([`View::shadow_period`]): those it
/// would have drawn have their next turn.
pub struct Recording<'a> {
    /// The queue that the encoder will be submitted to.
    pub queue: &'a wgpu::Queue,
    /// The encoder.
    pub encoder: &'a mut wgpu::CommandEncoder,
    /// What measures passes, if anything.
    pub timing: Timing<'a>,
}

impl<'a> Recording<'a> {
    /// Without measuring anything.
    pub fn new(queue: &'a wgpu::Queue, encoder: &'a mut wgpu::CommandEncoder) -> Self {
        Self { queue, encoder, timing: Timing::NONE }
    }
}

/// Something that draws into a whole picture beside what Windfall draws: a host's own things, or loose leaves by
/// another method (`windfall-papers`).
pub trait Layer {
    /// Before the passes of the view, whose lists are made.
    fn prepare(&mut self, recording: &mut Recording<'_>, frame: &LayerFrame<'_>);
    /// In the pass that draws the scene; group 0 is the frame's.
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, frame: &LayerFrame<'_>);
    /// In the pass of a shadow map, 0 nearest to the camera.
    fn draw_shadow(&self, pass: &mut wgpu::RenderPass<'_>, frame: &LayerFrame<'_>, cascade: usize);
    /// Once the scene is drawn, before tone mapping.
    fn finish(
        &mut self,
        recording: &mut Recording<'_>,
        frame: &LayerFrame<'_>,
        scene: &SceneTextures<'_>,
    ) {
        let _ = (recording, frame, scene);
    }
    /// Whether depth is read after the scene's pass.
    fn reads_depth(&self) -> bool {
        false
    }
}

/// What a layer sees of a frame.
#[derive(Clone, Copy)]
pub struct LayerFrame<'a> {
    /// The forest.
    pub forest: &'a Forest,
    /// The view.
    pub view: &'a View,
    /// Group 0.
    pub group: &'a wgpu::BindGroup,
    pub(crate) prepared: &'a Prepared,
}

impl LayerFrame<'_> {
    /// How the view simplifies trees.
    #[doc(hidden)]
    pub fn tree_list(&self) -> &crate::base::shared::TreeList {
        &self.prepared.cull.lists[0]
    }
}

/// What the scene was drawn into, 4 samples a pixel.
#[derive(Debug, Clone, Copy)]
pub struct SceneTextures<'a> {
    /// Linear radiance, `Rgba16Float`.
    pub radiance: &'a wgpu::TextureView,
    /// Depth, `Depth32Float`, 1 at the near plane; kept if [`Layer::reads_depth`].
    pub depth: &'a wgpu::TextureView,
}

/// A whole picture: where it goes, and what else is drawn into it.
pub struct Picture<'a> {
    /// The textures between the passes.
    pub targets: &'a PictureTargets,
    /// The picture: of the targets' size and the renderer's format, usage `RENDER_ATTACHMENT`.
    pub output: &'a wgpu::TextureView,
    /// Layers, in the order in which they are drawn.
    pub layers: &'a mut [&'a mut dyn Layer],
}

impl Renderer {
    /// Brings a forest to a moment: its changes, then what of its leaves is the same for all views. Once a frame,
    /// before the views are prepared; in one submission a forest has one moment.
    ///
    /// # Errors
    ///
    /// [`ForestError::TooManyLeaves`] and [`ForestError::TooManyTrees`], if the forest has outgrown the device.
    pub fn advance(
        &self,
        recording: &mut Recording<'_>,
        forest: &mut Forest,
        moment: Moment,
    ) -> Result<(), ForestError> {
        if forest.device != self.device {
            return Err(ForestError::OtherDevice { name: "the forest".to_owned() });
        }
        if !moment.time.is_finite() {
            return Err(ForestError::Number {
                what: "the time",
                value: moment.time,
                wanted: "finite",
            });
        }
        forest.begin(recording.queue, moment)?;
        forest.layouts.noise.upload(recording.queue);
        let structure = forest.structure();
        if forest.moment_group.as_ref().is_none_or(|(of, _)| *of != structure) {
            let scripted = forest.buffers().map(|buffers| self.moment_group(&buffers.scripted));
            forest.moment_group = scripted.map(|group| (structure, group));
        }
        let (Some(buffers), Some((_, group))) = (forest.buffers(), &forest.moment_group) else {
            return Ok(());
        };
        let Recording { queue, encoder, timing } = recording;
        let loose = &buffers.loose;
        queue.write_buffer(&group.buffer, 0, bytemuck::bytes_of(&forest.frame()));
        let fall = forest.fall_frame(loose.frame);
        queue.write_buffer(&loose.uniform, 0, bytemuck::bytes_of(&fall));
        encoder.clear_buffer(&loose.counters, 0, None);
        timing.compute_pass(encoder, "find", |pass| {
            pass.set_bind_group(0, &group.group, &[]);
            self.falls.collect_detached(pass, loose);
        });
        loose.copy_count(encoder, Counter::LandingGroups);
        timing.compute_pass(encoder, "land", |pass| {
            pass.set_bind_group(0, &group.group, &[]);
            self.falls.solve_landings(pass, loose);
        });
        timing.compute_pass(encoder, "pose", |pass| {
            pass.set_bind_group(0, &group.group, &[]);
            self.falls.pose(pass, loose);
        });
        loose.copy_count(encoder, Counter::ChangeGroups);
        loose.copy_count(encoder, Counter::CalmGroups);
        timing.compute_pass(encoder, "change", |pass| {
            pass.set_bind_group(0, &group.group, &[]);
            self.falls.transition(pass, loose);
            self.falls.settle(pass, loose);
        });
        Ok(())
    }

    /// Records what a view of `width` by `height` pixels needs before it is drawn: the light of the sky, lists of
    /// trees, loose leaves in view, and with [`crate::Layers::shadows`] the shadow maps. A shadow map of the
    /// host's is drawn before.
    ///
    /// # Errors
    ///
    /// [`ViewError`]: a view without pixels, a camera that cannot be, a state of another forest.
    pub fn prepare(
        &self,
        recording: &mut Recording<'_>,
        forest: &Forest,
        state: &mut ViewState,
        view: &View,
        size: (u32, u32),
    ) -> Result<(), ViewError> {
        self.begin(recording, forest, state, view, (size, None))?;
        self.shadow_maps(recording, forest, state, &[]);
        self.spread(recording, forest, state);
        Ok(())
    }

    /// Draws foliage with colours in the host's pass: wood, leaves on their twigs, in the air and on the ground,
    /// and the ground, grass and sky if the renderer has them. The pass has the targets of
    /// [`crate::Options`]; its bind groups, pipeline and buffers are other ones afterwards.
    ///
    /// # Errors
    ///
    /// [`ViewError::NotAdvanced`] if nothing was prepared, [`ViewError::NoLayer`] for a renderer of pictures.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &Forest,
        state: &ViewState,
    ) -> Result<(), ViewError> {
        if self.picture.is_some() {
            return Err(ViewError::NoLayer { layer: "a target of the host's (Layers::picture)" });
        }
        let (buffers, lists, prepared) = Self::prepared(forest, state)?;
        pass.set_bind_group(0, &state.frame.group, &[]);
        let mut pass = TimedPass::plain(pass);
        self.trees(&mut pass, buffers, lists, &prepared.view);
        pass.part("loose leaves", |pass| self.color.loose.draw(pass, buffers, &lists.loose));
        self.surroundings(&mut pass, forest, state, &prepared.view, true);
        Ok(())
    }

    /// Draws depth alone of foliage in the host's pass: its shadow map or depth pre-pass. The camera that was
    /// prepared is the light's.
    ///
    /// # Errors
    ///
    /// [`ViewError::NotAdvanced`] if nothing was prepared, [`ViewError::NoLayer`] without
    /// [`crate::Options::depth_only`].
    pub fn draw_depth(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &Forest,
        state: &ViewState,
    ) -> Result<(), ViewError> {
        let Some(passes) = &self.depth_only else {
            return Err(ViewError::NoLayer { layer: "Options::depth_only" });
        };
        let (buffers, lists, prepared) = Self::prepared(forest, state)?;
        pass.set_bind_group(0, &state.frame.group, &[]);
        depth(pass, passes, buffers, lists, 0, prepared.view.detail.fade.by);
        if let Some(quads) = lists.quads.as_ref().filter(|_| opaque(&prepared.view)) {
            passes.quads.draw(pass, quads);
        }
        passes.loose.draw(pass, buffers, &lists.loose);
        Ok(())
    }

    /// Records a whole picture: [`Renderer::prepare`], the scene, tone mapping. The forest has been advanced.
    ///
    /// # Errors
    ///
    /// Those of [`Renderer::prepare`], and [`ViewError::NoLayer`] without [`crate::Layers::picture`].
    pub fn render(
        &self,
        recording: &mut Recording<'_>,
        forest: &Forest,
        state: &mut ViewState,
        view: &View,
        picture: Picture<'_>,
    ) -> Result<(), ViewError> {
        let Some(passes) = &self.picture else {
            return Err(ViewError::NoLayer { layer: "Layers::picture" });
        };
        let Picture { targets, output, layers } = picture;
        let keep_depth = layers.iter().any(|layer| layer.reads_depth());
        // Layers that read depth know pixels of the picture alone, and so do pyramids of depth.
        let full = keep_depth
            .then(|| View { quality: Quality { resolution: 1.0, ..view.quality }, ..view.clone() });
        let view = full.as_ref().unwrap_or(view);
        let resolution = view.quality.drawn_resolution();
        let occlusion = view.culling == Culling::Occlusion && resolution == 1.0;
        let drawn = [targets.width, targets.height].map(|side| side as f32 * resolution);
        let viewport = |pass: &mut TimedPass<'_, '_>| {
            pass.pass.set_viewport(0.0, 0.0, drawn[0], drawn[1], 0.0, 1.0);
        };
        let pyramid = occlusion.then_some(&targets.pyramid);
        self.begin(recording, forest, state, view, ((targets.width, targets.height), pyramid))?;
        for layer in layers.iter_mut() {
            layer.prepare(recording, &Self::layer_frame(forest, state)?);
        }
        self.shadow_maps(recording, forest, state, layers);
        self.spread(recording, forest, state);
        let (buffers, lists, _) = Self::prepared(forest, state)?;
        let frame = Self::layer_frame(forest, state)?;
        let group = &state.frame.group;
        if occlusion {
            // What the frame before did not hide, and the ground, hide the rest of this frame.
            let Recording { encoder, timing, .. } = recording;
            timing.render_pass(encoder, targets.scene("visible before", true, true), |pass| {
                pass.pass.set_bind_group(0, group, &[]);
                self.trees(pass, buffers, lists, view);
                self.ground_of(pass, forest, state, view);
            });
            timing.compute_pass(encoder, "pyramid", |pass| {
                passes.hiz.build(pass, &targets.pyramid);
            });
            targets.pyramid.remember(encoder, &state.frame.buffer);
            timing.compute_pass(encoder, "cull again", |pass| {
                pass.set_bind_group(0, group, &[]);
                self.cull.make_hidden(pass, &lists.lists, &targets.pyramid.group);
                if let Some(quads) = lists.quads.as_ref().filter(|_| opaque(view)) {
                    self.quads.arrange(pass, quads);
                }
            });
            self.spread(recording, forest, state);
        }
        let Recording { encoder, timing, .. } = recording;
        timing.render_pass(encoder, targets.scene("forest", !occlusion, keep_depth), |pass| {
            viewport(pass);
            pass.pass.set_bind_group(0, group, &[]);
            self.trees(pass, buffers, lists, view);
            pass.part("loose leaves", |pass| {
                self.color.loose.draw(pass, buffers, &lists.loose);
                for layer in layers.iter() {
                    layer.draw(pass, &frame);
                }
            });
            self.surroundings(pass, forest, state, view, !occlusion);
        });
        let scene = SceneTextures { radiance: &targets.radiance, depth: &targets.depth };
        for layer in layers.iter_mut() {
            layer.finish(recording, &frame, &scene);
        }
        let Recording { encoder, timing, .. } = recording;
        timing.render_pass(encoder, PictureTargets::picture(output), |pass| {
            pass.pass.set_bind_group(0, group, &[]);
            passes.tone_map.draw(pass.pass, &targets.radiance_group, resolution);
        });
        Ok(())
    }

    /// Writes the view's uniforms and makes its lists.
    fn begin(
        &self,
        recording: &mut Recording<'_>,
        forest: &Forest,
        state: &mut ViewState,
        view: &View,
        (size, pyramid): ((u32, u32), Option<&crate::view::pyramid::Pyramid>),
    ) -> Result<(), ViewError> {
        if let Light::Host(light) = &view.light {
            let cascades = light.shadow.as_ref().map_or(1, |shadow| shadow.cascades.len());
            if !(1..=CASCADES as usize).contains(&cascades) {
                return Err(ViewError::Cascades { cascades });
            }
        }
        let eye = view.camera.eye(forest.origin(), size)?;
        state.fit(forest, view)?;
        let Recording { queue, encoder, timing } = recording;
        let mut frame = Frame::zeroed();
        forest.describe(&mut frame);
        view.describe(&mut frame, &eye, forest.origin());
        let cascades = self.cascades(forest, state, view, &eye);
        if let Some((cascades, _)) = &cascades {
            cascades::describe(&mut frame, cascades, view.shadows);
        }
        let sway = forest.moment.sway && view.quality.sway;
        frame.sway = f32::from(u8::from(sway));
        queue.write_buffer(&state.frame.buffer, 0, bytemuck::bytes_of(&frame));
        if let Some(grass) = self.grass.as_ref().filter(|_| view.quality.grass) {
            let found =
                state.grass.get_or_insert_with(|| ViewGrass::new(&state.device, &forest.layouts));
            timing.compute_pass(encoder, "find grass", |pass| {
                pass.set_bind_group(0, &state.frame.group, &[]);
                grass.find(queue, pass, &forest.ground, found);
            });
        }
        if self.ground.is_some() {
            let pixels = eye.pixels * view.quality.drawn_resolution();
            let frustum = Frustum::new(eye.clip_from_world);
            let squares = forest.ground.squares(eye.position, pixels, &frustum);
            state.ground.write(&state.device, queue, &squares);
        }
        if let Some((cascades, _)) = &cascades {
            for (i, (cascade, group)) in cascades.iter().zip(&state.shadow_frames).enumerate() {
                let frame = cascade.frame(&frame, &cascades::detail_of(i, &view.shadow_detail));
                queue.write_buffer(&group.buffer, 0, bytemuck::bytes_of(&frame));
            }
        }
        if let (Light::Sky(sky, map), Some(of_view)) = (&view.light, &state.sky) {
            let picture = map.as_ref().map(|map| &map.light);
            self.sky_light.record(queue, encoder, *timing, of_view, (sky, picture));
            let at = std::mem::offset_of!(Frame, ambient) as u64;
            let size = size_of::<SkyUniform>() as u64;
            encoder.copy_buffer_to_buffer(&of_view.light, 0, &state.frame.buffer, at, size);
        }
        let (Some(forest_buffers), Some(buffers)) = (forest.buffers(), &state.buffers) else {
            return Err(ViewError::NotAdvanced);
        };
        let wind_speed = if sway { forest.wind().fastest() } else { 0.0 };
        let drawn = cascades.as_ref().filter(|_| view.shadows).map_or(&[][..], |(c, _)| &c[..]);
        let mut cull = cull_frame(view, &eye, drawn, forest_buffers, wind_speed);
        if let Some(pyramid) = pyramid {
            cull.top_level = pyramid.top_level();
        } else if view.culling == Culling::Occlusion {
            cull.lists[0].culling = Culling::Sphere as u32;
        }
        let ViewBuffers { lists, quads, loose } = buffers;
        queue.write_buffer(&lists.uniform, 0, bytemuck::bytes_of(&cull));
        encoder.clear_buffer(&lists.arguments, lists.tallies_offset(), None);
        let empty = &forest_buffers.loose.empty_draws;
        encoder.copy_buffer_to_buffer(empty, 0, &loose.counters, 0, empty.size());
        let views = if drawn.is_empty() { 1 } else { VIEWS };
        let pyramid = pyramid.map_or(&state.open_pyramid, |pyramid| &pyramid.group);
        timing.compute_pass(encoder, "cull", |pass| {
            pass.set_bind_group(0, &state.frame.group, &[]);
            self.cull.make(pass, lists, pyramid, views);
            if let Some(quads) = quads.as_ref().filter(|_| opaque(view)) {
                self.quads.arrange(pass, quads);
            }
        });
        timing.compute_pass(encoder, "select", |pass| {
            pass.set_bind_group(0, &state.frame.group, &[]);
            self.gather.select(pass, &forest_buffers.loose, loose);
        });
        loose.copy_count(encoder);
        timing.compute_pass(encoder, "gather", |pass| {
            pass.set_bind_group(0, &state.frame.group, &[]);
            self.gather.run(pass, loose);
        });
        state.prepared = Some(Prepared { view: view.clone(), cull, cascades });
        Ok(())
    }

    /// The cascades of Windfall's own shadow maps, where the view has them.
    fn cascades(
        &self,
        forest: &Forest,
        state: &mut ViewState,
        view: &View,
        eye: &crate::view::camera::Eye,
    ) -> Option<([Cascade; cascades::CASCADES], [bool; cascades::CASCADES])> {
        let of_host = matches!(&view.light, Light::Host(light) if light.shadow.is_some());
        let own = self.shadows.is_some() && state.shadows.is_some();
        if !own || of_host || eye.orthographic {
            return None;
        }
        let shown = Shown {
            structure: forest.structure(),
            origin: forest.origin(),
            detail: view.shadow_detail,
            size: view.quality.shadow_size,
        };
        let light = (view.light.sun_direction(), forest.moment.time);
        if !view.shadows {
            // No map is drawn, and none is kept.
            state.shadow_turns = ShadowTurns::default();
            return Some((cascades::cascades(eye, light.0, shown.size, 1.0), Default::default()));
        }
        Some(state.shadow_turns.next(eye, light, view.shadow_period, shown))
    }

    /// Draws Windfall's own shadow maps.
    fn shadow_maps(
        &self,
        recording: &mut Recording<'_>,
        forest: &Forest,
        state: &ViewState,
        layers: &[&mut dyn Layer],
    ) {
        let (Some(passes), Some(maps)) = (&self.shadows, &state.shadows) else { return };
        let Ok((buffers, lists, prepared)) = Self::prepared(forest, state) else { return };
        let Some((cascades, draw)) = prepared.cascades.as_ref().filter(|_| prepared.view.shadows)
        else {
            return;
        };
        let Ok(frame) = Self::layer_frame(forest, state) else { return };
        let Recording { encoder, timing, .. } = recording;
        for (i, cascade) in cascades.iter().enumerate().filter(|(i, _)| draw[*i]) {
            let FrameGroup { group, .. } = &state.shadow_frames[i];
            timing.render_pass(encoder, maps.pass(i), |pass| {
                let pass = &mut *pass.pass;
                pass.set_bind_group(0, group, &[]);
                let size = cascade.size as f32;
                pass.set_viewport(0.0, 0.0, size, size, 0.0, 1.0);
                depth(pass, passes, buffers, lists, i + 1, prepared.view.shadow_detail.fade.by);
                // What lies or falls farther away is too small to shade anything.
                if i < 2 {
                    passes.loose.draw(pass, buffers, &lists.loose);
                    for layer in layers {
                        layer.draw_shadow(pass, &frame, i);
                    }
                }
            });
        }
    }

    /// Places and lights the leaves that are drawn as quads.
    fn spread(&self, recording: &mut Recording<'_>, forest: &Forest, state: &ViewState) {
        let Ok((buffers, lists, prepared)) = Self::prepared(forest, state) else { return };
        let Some(quads) = lists.quads.as_ref().filter(|_| opaque(&prepared.view)) else { return };
        let Recording { encoder, timing, .. } = recording;
        timing.compute_pass(encoder, "spread", |pass| {
            pass.set_bind_group(0, &state.frame.group, &[]);
            self.quads.spread(pass, buffers, quads);
        });
    }

    /// Wood and the leaves on the twigs.
    fn trees(
        &self,
        pass: &mut TimedPass<'_, '_>,
        buffers: &ForestBuffers,
        lists: &ViewBuffers,
        view: &View,
    ) {
        if !view.show.leaves_alone() {
            pass.part("wood", |pass| {
                self.color.wood.draw(pass, buffers, (&lists.lists, (WOOD * VIEWS) as usize));
            });
        }
        pass.part("leaves", |pass| {
            self.color.leaves.draw(pass, buffers, (&lists.lists, 0), view.detail.fade.by);
            if let Some(quads) = lists.quads.as_ref().filter(|_| opaque(view)) {
                self.color.quads.draw(pass, quads);
            }
        });
    }

    /// Grass, the ground and the sky.
    fn surroundings(
        &self,
        pass: &mut TimedPass<'_, '_>,
        forest: &Forest,
        state: &ViewState,
        view: &View,
        ground: bool,
    ) {
        if view.show.trees_alone() {
            return;
        }
        if let Some(grass) = self.grass.as_ref().filter(|_| view.quality.grass)
            && let Some(found) = &state.grass
        {
            pass.part("grass", |pass| grass.draw(pass, &forest.ground, found));
        }
        if ground {
            self.ground_of(pass, forest, state, view);
        }
        if let Some(sky) = &self.sky {
            pass.part("sky", |pass| sky.draw(pass, view.quality.backdrop));
        }
    }

    fn ground_of(
        &self,
        pass: &mut TimedPass<'_, '_>,
        forest: &Forest,
        state: &ViewState,
        view: &View,
    ) {
        if let Some(ground) = self.ground.as_ref().filter(|_| !view.show.trees_alone()) {
            pass.part("ground", |pass| {
                ground.draw(pass, (&forest.ground, &state.ground), view.quality.ground_detail);
            });
        }
    }

    /// What was prepared of a view.
    fn prepared<'a>(
        forest: &'a Forest,
        state: &'a ViewState,
    ) -> Result<(&'a ForestBuffers, &'a ViewBuffers, &'a Prepared), ViewError> {
        state.check(forest)?;
        match (forest.buffers(), &state.buffers, &state.prepared) {
            (Some(forest), Some(buffers), Some(prepared)) => Ok((forest, buffers, prepared)),
            _ => Err(ViewError::NotAdvanced),
        }
    }

    fn layer_frame<'a>(
        forest: &'a Forest,
        state: &'a ViewState,
    ) -> Result<LayerFrame<'a>, ViewError> {
        let (_, _, prepared) = Self::prepared(forest, state)?;
        Ok(LayerFrame { forest, view: &prepared.view, group: &state.frame.group, prepared })
    }
}

/// Quads are opaque, and have a colour and nothing else: leaves that fade by opacity or are told apart are none.
fn opaque(view: &View) -> bool {
    view.detail.fade.by == FadeBy::Size && view.show != DebugView::Ids
}

/// Draws depth of the trees of a view or shadow map.
fn depth(
    pass: &mut wgpu::RenderPass<'_>,
    passes: &DepthPasses,
    buffers: &ForestBuffers,
    lists: &ViewBuffers,
    view: usize,
    fade: FadeBy,
) {
    passes.wood.draw(pass, buffers, (&lists.lists, (WOOD * VIEWS) as usize + view));
    passes.leaves.draw(pass, buffers, (&lists.lists, view), fade);
}

impl Moment {
    /// The moment of a view's picture: swaying, and coloured, as the view wants it.
    pub fn of(time: f64, view: &View) -> Self {
        Self { time, sway: view.quality.sway, color_loops: view.show == DebugView::Loops }
    }
}
