//! Leaves that have left their twigs: where they land, and where they are. Once a frame for all views.

use crate::base::constants::{BLOCK, MOST_TOGETHER, ROW, TOGETHER_FROM};
use crate::base::layouts::Layouts;
use crate::base::wgsl::{Module, Shaders, compose, text};
use crate::scene::falls::LooseState;

/// The module of falls.
pub const FALLS: Module = Module {
    name: "falls",
    source: |settings| {
        let sources = [
            text::TABLES,
            text::PATH_SAMPLES,
            text::SHED,
            text::POSE,
            text::LOOSE,
            text::REST,
            include_str!("falls.wgsl"),
        ];
        compose(settings, &sources)
    },
};

/// Lets leaves fall.
pub struct Falls {
    update_windows: wgpu::ComputePipeline,
    collect_detached: wgpu::ComputePipeline,
    wake: wgpu::ComputePipeline,
    solve_landings: wgpu::ComputePipeline,
    pose: wgpu::ComputePipeline,
    transition: wgpu::ComputePipeline,
    settle: wgpu::ComputePipeline,
}

/// Workgroups in rows: no side of a dispatch is longer than the device allows.
pub fn dispatch(pass: &mut wgpu::ComputePass<'_>, groups: u32) {
    pass.dispatch_workgroups(groups.min(ROW), groups.div_ceil(ROW), 1);
}

impl Falls {
    pub fn new(shaders: &Shaders<'_>, layouts: &Layouts) -> Self {
        let groups = [&layouts.frame, &layouts.falls];
        let pipeline = |entry| shaders.compute(&FALLS, entry, &groups, &[]);
        Self {
            update_windows: pipeline("update_windows"),
            collect_detached: pipeline("collect_detached"),
            wake: pipeline("wake"),
            solve_landings: pipeline("solve_landings"),
            pose: pipeline("pose"),
            transition: pipeline("transition"),
            settle: pipeline("settle"),
        }
    }

    /// Lists the leaves that have newly detached, and wakes the groups of slots where something may happen.
    pub fn collect_detached(&self, pass: &mut wgpu::ComputePass<'_>, loose: &LooseState) {
        let streams = loose.streams.all.len() as u32;
        pass.set_bind_group(1, &loose.group, &[]);
        pass.set_pipeline(&self.update_windows);
        pass.dispatch_workgroups(streams.div_ceil(BLOCK), 1, 1);
        pass.set_pipeline(&self.collect_detached);
        dispatch(pass, streams);
        pass.set_pipeline(&self.wake);
        pass.dispatch_workgroups((loose.streams.groups.len() as u32).div_ceil(BLOCK), 1, 1);
    }

    /// Finds where they will land.
    pub fn solve_landings(&self, pass: &mut wgpu::ComputePass<'_>, loose: &LooseState) {
        pass.set_bind_group(1, &loose.group, &[]);
        pass.set_pipeline(&self.solve_landings);
        pass.dispatch_workgroups_indirect(&loose.indirect, 0);
    }

    /// Poses the loose leaves that fly or lie.
    pub fn pose(&self, pass: &mut wgpu::ComputePass<'_>, loose: &LooseState) {
        pass.set_bind_group(1, &loose.group, &[]);
        pass.set_pipeline(&self.pose);
        let groups = loose.streams.groups.len() as u32;
        let together = (groups / TOGETHER_FROM).clamp(1, MOST_TOGETHER);
        dispatch(pass, groups.div_ceil(together));
    }

    /// Poses the leaves that leave their twigs, settle, or vanish.
    pub fn transition(&self, pass: &mut wgpu::ComputePass<'_>, loose: &LooseState) {
        pass.set_bind_group(1, &loose.group, &[]);
        pass.set_pipeline(&self.transition);
        pass.dispatch_workgroups_indirect(&loose.indirect, 12);
    }

    /// Notes which groups of slots have come to rest.
    pub fn settle(&self, pass: &mut wgpu::ComputePass<'_>, loose: &LooseState) {
        pass.set_bind_group(1, &loose.group, &[]);
        pass.set_pipeline(&self.settle);
        pass.dispatch_workgroups_indirect(&loose.indirect, 24);
    }
}
