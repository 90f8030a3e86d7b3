//! GPU time by pass, where the host wants to know it.
//!
//! Every pass of a frame is recorded through [`Timing`]: with the feature `profiler` and a
//! [`wgpu_profiler::GpuProfiler`] of the host's it is measured, without it costs nothing.

/// What measures passes; nothing by default.
#[derive(Clone, Copy, Default)]
pub struct Timing<'a> {
    #[cfg(feature = "profiler")]
    profiler: Option<&'a wgpu_profiler::GpuProfiler>,
    #[cfg(not(feature = "profiler"))]
    nothing: std::marker::PhantomData<&'a ()>,
}

impl std::fmt::Debug for Timing<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Timing")
    }
}

#[cfg(feature = "profiler")]
impl<'a> From<&'a wgpu_profiler::GpuProfiler> for Timing<'a> {
    fn from(profiler: &'a wgpu_profiler::GpuProfiler) -> Self {
        Self { profiler: Some(profiler) }
    }
}

impl Timing<'_> {
    /// Nothing is measured.
    pub const NONE: Timing<'static> = Timing {
        #[cfg(feature = "profiler")]
        profiler: None,
        #[cfg(not(feature = "profiler"))]
        nothing: std::marker::PhantomData,
    };

    /// Records a render pass.
    pub fn render_pass(
        self,
        encoder: &mut wgpu::CommandEncoder,
        targets: PassTargets<'_>,
        body: impl FnOnce(&mut TimedPass<'_, '_>),
    ) {
        let PassTargets { label, color, depth } = targets;
        let colors = [color];
        let colors = if colors[0].is_some() { &colors[..] } else { &[] };
        self.render_pass_into(encoder, label, (colors, depth), body);
    }

    /// Records a render pass with any number of colours.
    pub fn render_pass_into(
        self,
        encoder: &mut wgpu::CommandEncoder,
        label: &str,
        (colors, depth): (
            &[Option<wgpu::RenderPassColorAttachment<'_>>],
            Option<wgpu::RenderPassDepthStencilAttachment<'_>>,
        ),
        body: impl FnOnce(&mut TimedPass<'_, '_>),
    ) {
        let descriptor = wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: colors,
            depth_stencil_attachment: depth,
            ..Default::default()
        };
        #[cfg(feature = "profiler")]
        if let Some(profiler) = self.profiler {
            let query = profiler.begin_pass_query(label, encoder);
            {
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    timestamp_writes: query.render_pass_timestamp_writes(),
                    ..descriptor
                });
                body(&mut TimedPass { pass: &mut pass, timer: Some((profiler, &query)) });
            }
            profiler.end_query(encoder, query);
            return;
        }
        let mut pass = encoder.begin_render_pass(&descriptor);
        body(&mut TimedPass::plain(&mut pass));
    }

    /// Records a compute pass.
    pub fn compute_pass(
        self,
        encoder: &mut wgpu::CommandEncoder,
        label: &str,
        body: impl FnOnce(&mut wgpu::ComputePass<'_>),
    ) {
        #[cfg(feature = "profiler")]
        if let Some(profiler) = self.profiler {
            let query = profiler.begin_pass_query(label, encoder);
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(label),
                    timestamp_writes: query.compute_pass_timestamp_writes(),
                });
                body(&mut pass);
            }
            profiler.end_query(encoder, query);
            return;
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(label),
            timestamp_writes: None,
        });
        body(&mut pass);
    }
}

/// Where a render pass draws.
pub struct PassTargets<'a> {
    /// Its name, for people.
    pub label: &'a str,
    /// The colours, if any.
    pub color: Option<wgpu::RenderPassColorAttachment<'a>>,
    /// The depth, if any.
    pub depth: Option<wgpu::RenderPassDepthStencilAttachment<'a>>,
}

/// A render pass whose parts can be measured.
pub struct TimedPass<'a, 'p> {
    /// The pass.
    pub pass: &'a mut wgpu::RenderPass<'p>,
    #[cfg(feature = "profiler")]
    timer: Option<(&'a wgpu_profiler::GpuProfiler, &'a wgpu_profiler::GpuProfilerQuery)>,
    #[cfg(not(feature = "profiler"))]
    nothing: std::marker::PhantomData<&'a ()>,
}

impl<'a, 'p> TimedPass<'a, 'p> {
    /// One that is not measured.
    pub(crate) fn plain(pass: &'a mut wgpu::RenderPass<'p>) -> Self {
        Self {
            pass,
            #[cfg(feature = "profiler")]
            timer: None,
            #[cfg(not(feature = "profiler"))]
            nothing: std::marker::PhantomData,
        }
    }

    /// Records a part of the pass.
    pub fn part(&mut self, label: &str, body: impl FnOnce(&mut wgpu::RenderPass<'p>)) {
        #[cfg(feature = "profiler")]
        if let Some((profiler, parent)) = self.timer {
            let query = profiler.begin_query(label, self.pass).with_parent(Some(parent));
            body(self.pass);
            profiler.end_query(self.pass, query);
            return;
        }
        let _ = label;
        body(self.pass);
    }
}
