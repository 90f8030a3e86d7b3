//! Makes the lists of trees that are drawn: which, in which detail, and the arguments of their draws.

use crate::base::constants::KINDS;
use crate::base::layouts::Layouts;
use crate::base::wgsl::{Module, Shaders, compose, text};
use crate::view::lists::TreeLists;

/// The module of the lists.
pub const CULL: Module = Module {
    name: "cull",
    source: |settings| compose(settings, &[text::SHED, text::SIMPLIFY, include_str!("cull.wgsl")]),
};

/// Makes lists.
pub struct Cull {
    classify: wgpu::ComputePipeline,
    reclassify: wgpu::ComputePipeline,
    prefix_sum: wgpu::ComputePipeline,
    scatter: wgpu::ComputePipeline,
}

impl Cull {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts) -> Self {
        let groups = [&layouts.frame, &layouts.cull, &layouts.pyramid];
        let pipeline = |entry| shaders.compute(&CULL, entry, &groups, &[]);
        Self {
            classify: pipeline("classify"),
            reclassify: pipeline("reclassify"),
            prefix_sum: pipeline("prefix_sum"),
            scatter: pipeline("scatter"),
        }
    }

    /// Makes the lists of the first `views` of `CullFrame::lists`.
    pub fn make(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        lists: &TreeLists,
        pyramid: &wgpu::BindGroup,
        views: u32,
    ) {
        self.run(pass, lists, pyramid, &self.classify, views);
    }

    /// Makes the lists of the view anew, of the trees that the pyramid of the frame before hid and that
    /// of this frame does not.
    pub fn make_hidden(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        lists: &TreeLists,
        pyramid: &wgpu::BindGroup,
    ) {
        self.run(pass, lists, pyramid, &self.reclassify, 1);
    }

    fn run(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        lists: &TreeLists,
        pyramid: &wgpu::BindGroup,
        classify: &wgpu::ComputePipeline,
        views: u32,
    ) {
        let rows = KINDS * views;
        if lists.blocks == 0 {
            return;
        }
        pass.set_bind_group(1, &lists.group, &[]);
        pass.set_bind_group(2, pyramid, &[]);
        pass.set_pipeline(classify);
        pass.dispatch_workgroups(lists.blocks, rows, 1);
        pass.set_pipeline(&self.prefix_sum);
        pass.dispatch_workgroups(lists.models, rows, 1);
        pass.set_pipeline(&self.scatter);
        pass.dispatch_workgroups(lists.blocks, rows, 1);
    }
}
