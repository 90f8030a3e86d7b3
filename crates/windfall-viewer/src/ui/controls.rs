//! Sections of the panel about what is in the scene. Each is given the scene's settings, to go back to.

use super::values::{choice, slider, switch};
use crate::state::settings::Settings;
use egui::Ui;
use windfall_scenes::{Source, TreeEntry, VariationEntry};
use windfall_tree::Species;

pub fn trees(ui: &mut Ui, settings: &mut Settings, base: &Settings) {
    let (scene, base) = (&mut settings.scene, &base.scene);
    slider(ui, ("trees", "of the forest"), &mut scene.count, base.count, 0..=2000, |s| {
        s.logarithmic(true)
    });
    let mut remove = None;
    let several = scene.trees.len() > 1;
    for (i, tree) in scene.trees.iter_mut().enumerate() {
        ui.push_id(i, |ui| {
            ui.horizontal_wrapped(|ui| {
                match &mut tree.source {
                    Source::Species(name) => {
                        egui::ComboBox::from_id_salt("species")
                            .selected_text(name.as_str())
                            .width(80.0)
                            .show_ui(ui, |ui| {
                                for species in Species::ALL {
                                    let text = species.name().to_owned();
                                    ui.selectable_value(name, text.clone(), text);
                                }
                            });
                    }
                    Source::File(name) => {
                        let short = name.rsplit(['/', '\\']).next().unwrap_or(name);
                        ui.label(short).on_hover_text(name.as_str());
                    }
                }
                let weight = egui::DragValue::new(&mut tree.weight).range(0.01..=100.0).speed(0.05);
                ui.add(weight).on_hover_text("share of the forest");
                let mut height = tree.height.unwrap_or(0.0);
                let field = egui::DragValue::new(&mut height).range(0.0..=200.0).speed(0.1);
                let field = field.custom_formatter(|height, _| {
                    if height > 0.0 { format!("{height:.1} m") } else { "own height".to_owned() }
                });
                if ui.add(field).on_hover_text("height; 0 is the model's own").changed() {
                    tree.height = (height > 0.0).then_some(height);
                }
                if several && ui.small_button("✖").on_hover_text("remove").clicked() {
                    remove = Some(i);
                }
            });
        });
    }
    if let Some(i) = remove {
        scene.trees.remove(i);
    }
    ui.horizontal_wrapped(|ui| {
        if ui.button("Add a species").clicked() {
            let entry = TreeEntry::new(Source::Species("oak".to_owned()));
            scene.trees.push(TreeEntry { variants: 1, ..entry });
        }
        if scene.trees != base.trees && ui.button("⟲").on_hover_text("the scene's trees").clicked()
        {
            scene.trees.clone_from(&base.trees);
            scene.spacing = base.spacing;
        }
    });
    let mut spacing = scene.spacing.unwrap_or(0.0);
    let was = base.spacing.unwrap_or(0.0);
    let about = ("spacing, m", "least distance between trunks; 0 follows the crowns");
    if slider(ui, about, &mut spacing, was, 0.0..=30.0, |s| s) {
        scene.spacing = (spacing > 0.0).then_some(spacing);
    }
    slider(ui, ("seed", "key of everything random"), &mut scene.seed, base.seed, 0..=9999, |s| s);
    slider(
        ui,
        ("hills, m", "height of hills"),
        &mut scene.terrain.relief,
        base.terrain.relief,
        0.0..=30.0,
        |s| s,
    );
    slider(
        ui,
        ("meadow", "0 litter, 1 grass"),
        &mut scene.terrain.meadow,
        base.terrain.meadow,
        0.0..=1.0,
        |s| s,
    );
}

pub fn season(ui: &mut Ui, settings: &mut Settings, of_base: &Settings) {
    let base = &of_base.scene;
    let scene = &mut settings.scene;
    let about = ("season", "phase of autumn: 0 late summer, 1 bare");
    slider(ui, about, &mut scene.season, base.season, 0.0..=1.0, |s| s);
    let about = ("spread of trees", "how much trees are early or late");
    slider(ui, about, &mut scene.season_spread, base.season_spread, 0.0..=1.0, |s| s);
    let mut sheds = scene.shedding.is_some();
    switch(ui, "leaves fall", &mut sheds, base.shedding.is_some());
    if sheds != scene.shedding.is_some() {
        scene.shedding = sheds.then(|| base.shedding.unwrap_or_default());
    }
    if let Some(shedding) = &mut scene.shedding {
        let was = base.shedding.unwrap_or_default();
        ui.add_enabled_ui(settings.throw_rate.is_none(), |ui| {
            slider(
                ui,
                ("first leaf, s", "when shedding starts"),
                &mut shedding.start,
                was.start,
                -1000.0..=1000.0,
                |s| s,
            );
            let about = ("duration, s", "from a tree's first leaf to its last");
            slider(ui, about, &mut shedding.duration, was.duration, 1.0..=10_000.0, |s| {
                s.logarithmic(true)
            });
            slider(
                ui,
                ("peak", "gathers leaves in the middle"),
                &mut shedding.peak,
                was.peak,
                0.0..=0.95,
                |s| s,
            );
            slider(
                ui,
                ("bursts", "gathers leaves in gusts"),
                &mut shedding.burst,
                was.burst,
                0.0..=0.95,
                |s| s,
            );
            let about = ("trees apart, s", "seconds by which early trees are early");
            slider(ui, about, &mut shedding.tree_spread, was.tree_spread, 0.0..=1000.0, |s| s);
        });
        let mut throws = settings.throw_rate.is_some();
        switch(ui, "throw leaves at a rate instead", &mut throws, false);
        if throws != settings.throw_rate.is_some() {
            settings.throw_rate = throws.then_some(100.0);
        }
        if let Some(rate) = &mut settings.throw_rate {
            let about = ("leaves a second", "over the whole forest, from 0 s on");
            slider(ui, about, rate, 100.0, 0.1..=100_000.0, |s| s.logarithmic(true));
        }
    }
    let fall = &mut scene.fall;
    ui.collapsing("How leaves fall", |ui| {
        let was = base.fall;
        slider(
            ui,
            ("soft drop, m", "eases from the twig"),
            &mut fall.soft_drop,
            was.soft_drop,
            0.0..=5.0,
            |s| s,
        );
        slider(
            ui,
            ("soft time, s", "starts from rest"),
            &mut fall.soft_time,
            was.soft_time,
            0.0..=3.0,
            |s| s,
        );
        slider(
            ui,
            ("settle time, s", "eases onto the ground"),
            &mut fall.settle_time,
            was.settle_time,
            0.0..=3.0,
            |s| s,
        );
        slider(
            ui,
            ("settle turn, °", "most by which it turns then"),
            &mut fall.settle_turn,
            was.settle_turn,
            0.0..=360.0,
            |s| s,
        );
        slider(
            ui,
            ("wind response, s", "takes on the wind's speed"),
            &mut fall.wind_response,
            was.wind_response,
            0.01..=3.0,
            |s| s,
        );
        let names = ["hashed", "paper 2008", "paper 2007"];
        let values =
            [VariationEntry::default(), VariationEntry::Paper(2008), VariationEntry::Paper(2007)];
        let name = |v: VariationEntry| {
            values.iter().position(|x| *x == v).map_or("own", |i| names[i]).to_owned()
        };
        choice(ui, "variation", &mut scene.variation, base.variation, &values, name);
        for path in &scene.paths {
            ui.label(format!("path: {}", path.file));
        }
        if !scene.paths.is_empty() && ui.button("Built-in paths").clicked() {
            scene.paths.clear();
        }
    });
    slider(
        ui,
        ("loose leaves", "most in the air and on the ground"),
        &mut scene.loose_leaves,
        base.loose_leaves,
        0..=4_000_000,
        |s| s.logarithmic(true),
    );
}

pub fn wind(ui: &mut Ui, settings: &mut Settings, base: &Settings) {
    let (wind, was) = (&mut settings.scene.wind, base.scene.wind);
    slider(ui, ("speed, m/s", "of the mean wind"), &mut wind.speed, was.speed, 0.0..=15.0, |s| s);
    slider(
        ui,
        ("heading, °", "it blows to: 0 +X, 90 +Z"),
        &mut wind.heading,
        was.heading,
        -180.0..=180.0,
        |s| s,
    );
    slider(
        ui,
        ("gusts", "largest gust over the speed"),
        &mut wind.gustiness,
        was.gustiness,
        0.0..=1.0,
        |s| s,
    );
}

pub fn sky(ui: &mut Ui, settings: &mut Settings, base: &Settings) {
    let (sky, was) = (&mut settings.scene.sky, &base.scene.sky);
    let mut hour = hour_of(sky.azimuth, sky.elevation);
    if slider(
        ui,
        ("hour", "time of an October day in the north"),
        &mut hour,
        hour_of(was.azimuth, was.elevation),
        7.0..=17.0,
        |s| s.max_decimals(2),
    ) {
        (sky.azimuth, sky.elevation) = sun_at(hour);
    }
    slider(
        ui,
        ("azimuth, °", "of the sun: 0 +Z, 90 +X"),
        &mut sky.azimuth,
        was.azimuth,
        0.0..=360.0,
        |s| s,
    );
    slider(
        ui,
        ("elevation, °", "of the sun"),
        &mut sky.elevation,
        was.elevation,
        0.0..=90.0,
        |s| s,
    );
    slider(
        ui,
        ("turbidity", "haze high above: 2 clear, 5 hazy"),
        &mut sky.turbidity,
        was.turbidity,
        1.0..=10.0,
        |s| s,
    );
    slider(ui, ("haze, 1/m", "near the ground"), &mut sky.haze, was.haze, 0.0..=0.02, |s| {
        s.max_decimals(4)
    });
    slider(ui, ("clouds", "share of the sky"), &mut sky.clouds, was.clouds, 0.0..=1.0, |s| s);
    slider(ui, ("exposure, stops", ""), &mut sky.exposure, was.exposure, -4.0..=4.0, |s| s);
    if let Some(picture) = &sky.picture {
        ui.label(format!("picture: {picture}"));
        if ui.button("Without the picture").clicked() {
            sky.picture = None;
        }
    }
    switch(ui, "shadows", &mut settings.scene.shadows, base.scene.shadows);
}

/// Latitude and the sun's declination of a day in October, degrees.
const DAY: (f32, f32) = (48.0, -8.0);

/// Where the sun stands at an hour: azimuth and elevation as scenes have them. South is +Z.
fn sun_at(hour: f32) -> (f32, f32) {
    let (latitude, declination) = (DAY.0.to_radians(), DAY.1.to_radians());
    let angle = ((hour - 12.0) * 15.0).to_radians();
    let up = latitude.sin() * declination.sin() + latitude.cos() * declination.cos() * angle.cos();
    // From the south towards the west, which is -X.
    let west = angle.sin() * declination.cos();
    let south =
        angle.cos() * declination.cos() * latitude.sin() - declination.sin() * latitude.cos();
    ((-west).atan2(south).to_degrees().rem_euclid(360.0), up.asin().to_degrees().max(0.0))
}

/// The hour at which the sun stands nearest to there.
fn hour_of(azimuth: f32, elevation: f32) -> f32 {
    let miss = |hour: f32| {
        let (a, e) = sun_at(hour);
        let turn = (a - azimuth + 180.0).rem_euclid(360.0) - 180.0;
        (turn * elevation.to_radians().cos()).hypot(e - elevation)
    };
    (0..=200)
        .map(|i| 7.0 + i as f32 * 0.05)
        .min_by(|a, b| miss(*a).total_cmp(&miss(*b)))
        .unwrap_or(12.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_goes_from_east_to_west() {
        let (noon, high) = sun_at(12.0);
        assert!(noon.abs() < 1e-3 && (high - 34.0).abs() < 1e-3, "{noon} {high}");
        let (morning, _) = sun_at(8.0);
        let (evening, _) = sun_at(16.0);
        assert!((0.0..180.0).contains(&morning) && evening > 180.0, "{morning} {evening}");
        for hour in [8.0, 10.5, 12.0, 15.25] {
            let (azimuth, elevation) = sun_at(hour);
            assert!((hour_of(azimuth, elevation) - hour).abs() < 0.06, "{hour}");
        }
    }
}
