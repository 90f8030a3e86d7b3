//! VB's pictures of whole scenes with what they cost: 2008, figure 8; 2007, figure 1.

use super::report::{Figure, Row, Table};
use crate::falling::workload::{grove_of, walkthrough};
use crate::harness::{Harness, ImageTarget, upload_models};
use crate::statistics::Quartiles;
use std::path::Path;
use windfall_gpu::{Falls, Quality, View};
use windfall_host::device::Gpu;
use windfall_scenes::Stage;

/// Leaves of a tree of the scenes; with its wood it has some 145 thousand triangles.
const LEAVES: u32 = 7400;

/// A scene of the papers.
struct Scene {
    name: &'static str,
    title: &'static str,
    trees: u32,
    /// Leaves in the air.
    falling: u32,
}

const SCENES: [Scene; 4] = [
    Scene {
        name: "figure8-3k",
        title: "VB 2008, figure 8: 1 M triangles, 3 thousand leaves",
        trees: 7,
        falling: 3000,
    },
    Scene {
        name: "figure8-24k",
        title: "VB 2008, figure 8: 1.2 M triangles, 24.7 thousand leaves",
        trees: 8,
        falling: 24_700,
    },
    Scene {
        name: "figure1-7k",
        title: "VB 2007, figure 1: 1 M triangles, 7 thousand leaves",
        trees: 7,
        falling: 7000,
    },
    Scene {
        name: "figure1-13k",
        title: "VB 2007, figure 1: 1 M triangles, 13.5 thousand leaves",
        trees: 7,
        falling: 13_500,
    },
];

/// A moment of the walk at which leaves fall, and lie, seconds.
const MOMENT: f64 = 8.0;

/// Draws and times all of them.
pub fn measure(
    gpu: &mut Gpu,
    quick: bool,
    folder: &Path,
    number: usize,
) -> anyhow::Result<(Table, Vec<Figure>)> {
    let (size, frames) = if quick { ((480, 270), 4) } else { ((1280, 720), 12) };
    println!("scenes of VB");
    let harness = Harness::new(gpu, size)?;
    let target = ImageTarget::new(gpu, &harness.renderer, size, 1)?;
    let (mut rows, mut figures) = (Vec::new(), Vec::new());
    for scene in SCENES {
        let still = grove_of(scene.trees, LEAVES);
        let models = upload_models(gpu, &still)?;
        let mut stage = still.clone();
        stage.keep_falling(scene.falling);
        let bare = Stage { falls: Falls::none(), ..still };
        let mut planted = [&stage, &bare]
            .map(|stage| harness.plant(gpu, stage, &models))
            .into_iter()
            .collect::<Result<Vec<_>, _>>()?;
        let mut times = [Vec::new(), Vec::new()];
        let mut falling = 0;
        for frame in 0..frames + 2 {
            let seconds = MOMENT + f64::from(frame) / 30.0;
            let view = walkthrough(&stage, seconds);
            for (planted, times) in planted.iter_mut().zip(&mut times) {
                let measured = harness.measure(gpu, planted, (seconds, &view))?;
                falling = falling.max(measured.counts.falling);
                if frame >= 2 {
                    times.push(measured.wall_ms);
                }
            }
        }
        let [ms, without] = times.map(|times| Quartiles::of(&times));
        rows.push(Row {
            name: scene.title.into(),
            ms,
            measured: Some(without.median / ms.median),
            printed: None,
            notes: format!("{falling} in the air, {}K triangles", triangles(&stage) / 1000),
        });
        let view = View { quality: Quality::MEDIUM, ..walkthrough(&stage, MOMENT) };
        let image = target.render(gpu, &harness.renderer, &mut planted[0], (MOMENT, &view))?;
        let name = format!("{}-{number}", scene.name);
        figures.push(Figure::save(&image, folder, &name, scene.title)?);
    }
    let table = Table {
        id: "vb-scenes".into(),
        title: "VB 2008, figure 8; VB 2007, figure 1: whole scenes".into(),
        scene: format!("Frames of the walk at {}x{}, compute path", size.0, size.1),
        ratio: "frame rate over that of the same trees without falling leaves".into(),
        rows,
        remark: "The figures are pictures without numbers. The trees differ: the paper's stand in a row on bare ground, \
                 and a leaf has 6 triangles; here leaves far away have two. What leaves in the air \
                 cost follows from their number, and is little beside the trees here."
            .into(),
        plot: None,
    };
    Ok((table, figures))
}

/// Triangles of the trees of a stage.
pub fn triangles(stage: &Stage) -> u64 {
    let of = |model: u32| {
        let tree = &stage.trees[model as usize];
        (tree.foliage.triangle_count() + tree.wood.indices.len() / 3) as u64
    };
    stage.forest.instances.iter().map(|i| of(i.model)).sum()
}
