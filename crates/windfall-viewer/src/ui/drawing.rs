//! Sections of the panel about how the forest is drawn.

use super::values::{choice, slider, switch};
use crate::state::settings::{Settings, effects as switches};
use egui::Ui;
use windfall_core::simplify::{FadeBy, FadeRange, PruneOrder, Reduction};
use windfall_gpu::DebugView;
use windfall_scenes::{Culling, Elimination, QualityPreset, Strategy};

pub fn detail(ui: &mut Ui, settings: &mut Settings, base: &Settings) {
    let order = |o: PruneOrder| o.to_string();
    choice(
        ui,
        "prune order",
        &mut settings.scene.prune_order,
        base.scene.prune_order,
        &PruneOrder::ALL,
        order,
    );
    let (detail, was) = (&mut settings.scene.detail, &base.scene.detail);
    slider(
        ui,
        ("h", "size at which half of the leaves are drawn; 0 draws all"),
        &mut detail.h,
        was.h,
        0.0..=0.99,
        |s| s,
    );
    match &mut detail.reduction {
        Reduction::Distance { d0 } => {
            let before = if let Reduction::Distance { d0 } = was.reduction { d0 } else { 30.0 };
            slider(
                ui,
                ("d0, m", "distance up to which trees are in full"),
                d0,
                before,
                1.0..=500.0,
                |s| s.logarithmic(true),
            );
        }
        Reduction::ProjectedArea { b0 } => {
            let before = if let Reduction::ProjectedArea { b0 } = was.reduction { b0 } else { 1e5 };
            slider(
                ui,
                ("b0, pixels", "size above which trees are in full"),
                b0,
                before,
                100.0..=1e7,
                |s| s.logarithmic(true),
            );
        }
    }
    slider(
        ui,
        ("growth", "most that a leaf grows in length"),
        &mut detail.growth.factor,
        was.growth.factor,
        1.0..=16.0,
        |s| s.logarithmic(true),
    );
    slider(
        ui,
        ("growth, pixels", "up to which any growth is allowed"),
        &mut detail.growth.pixels,
        was.growth.pixels,
        0.0..=32.0,
        |s| s,
    );
    let fade = |f: FadeBy| if f == FadeBy::Size { "size" } else { "opacity" }.to_owned();
    choice(ui, "fade by", &mut detail.fade.by, was.fade.by, &[FadeBy::Size, FadeBy::Opacity], fade);
    let (FadeRange::Constant(range)
    | FadeRange::Linear(range)
    | FadeRange::Quadratic(range)
    | FadeRange::Proportional(range)) = &mut detail.fade.range;
    let (FadeRange::Constant(before)
    | FadeRange::Linear(before)
    | FadeRange::Quadratic(before)
    | FadeRange::Proportional(before)) = was.fade.range;
    slider(ui, ("fade range", "ranks over which leaves fade"), range, before, 0.0..=1.0, |s| s);
    switch(ui, "smooth fade", &mut detail.fade.smooth, was.fade.smooth);
    switch(ui, "early fade", &mut detail.fade.early, was.fade.early);
    switch(ui, "no fade in full", &mut detail.fade.full_at_one, was.fade.full_at_one);
    switch(ui, "leaves grow", &mut detail.area_preservation, was.area_preservation);
    switch(ui, "contrast of colour", &mut detail.color_contrast, was.color_contrast);
    switch(ui, "contrast of shading", &mut detail.shading_contrast, was.shading_contrast);
    slider(
        ui,
        ("wood, pixels", "error of simplified wood"),
        &mut detail.wood_pixels,
        was.wood_pixels,
        0.0..=8.0,
        |s| s,
    );
    slider(
        ui,
        ("leaf, pixels", "length below which leaves are simple"),
        &mut detail.leaf_pixels,
        was.leaf_pixels,
        0.0..=40.0,
        |s| s,
    );
}

pub fn method(ui: &mut Ui, settings: &mut Settings, base: &Settings) {
    let (scene, base) = (&mut settings.scene, &base.scene);
    choice(ui, "strategy", &mut scene.strategy, base.strategy, &Strategy::ALL, |s| s.to_string());
    choice(ui, "elimination", &mut scene.elimination, base.elimination, &Elimination::ALL, |s| {
        s.to_string()
    });
    if scene.elimination == Elimination::Progressive {
        slider(
            ui,
            ("leaves a frame", "that elimination tests"),
            &mut scene.elimination_per_frame,
            base.elimination_per_frame,
            1..=1000,
            |s| s,
        );
    }
    ui.add_enabled_ui(scene.strategy != Strategy::Compute, |ui| {
        switch(ui, "leaf occlusion", &mut scene.leaf_occlusion, base.leaf_occlusion);
    });
    choice(ui, "culling", &mut scene.culling, base.culling, &Culling::ALL, |c| c.to_string());
}

pub fn effects(ui: &mut Ui, settings: &mut Settings, base: &Settings) {
    let before = settings.scene.quality;
    choice(
        ui,
        "preset",
        &mut settings.scene.quality,
        base.scene.quality,
        &QualityPreset::ALL,
        |q| q.to_string(),
    );
    if settings.scene.quality != before {
        settings.quality = settings.scene.quality.into();
    }
    let mut preset = settings.scene.quality.into();
    for ((name, on), (_, of_preset)) in
        switches(&mut settings.quality).into_iter().zip(switches(&mut preset))
    {
        switch(ui, name, on, *of_preset);
    }
    let about = ("resolution", "of the picture, part of the window's");
    slider(ui, about, &mut settings.quality.resolution, preset.resolution, 0.25..=1.0, |s| s);
    slider(
        ui,
        ("shadow map", "texels a side"),
        &mut settings.quality.shadow_size,
        preset.shadow_size,
        256..=2048,
        |s| s,
    );
    slider(
        ui,
        ("shadow samples", "at a pixel of the ground"),
        &mut settings.quality.shadow_taps,
        preset.shadow_taps,
        1..=16,
        |s| s,
    );
}

pub fn view(ui: &mut Ui, settings: &mut Settings) {
    let name = |view: DebugView| {
        match view {
            DebugView::Final => "final",
            DebugView::Loops => "loop colours",
            DebugView::Detail => "λ heat map",
            DebugView::Leaves => "leaves alone",
            DebugView::Coverage => "coverage of leaves",
            DebugView::Occlusion => "visibility states (leaf occlusion)",
            DebugView::Radiance => "radiance of leaves",
            DebugView::Ids => "each leaf in a colour of its own",
            DebugView::Parts => "leaves and wood as read",
            DebugView::Normals => "normals",
        }
        .to_owned()
    };
    choice(ui, "view", &mut settings.show, DebugView::Final, DebugView::ALL, name);
}
