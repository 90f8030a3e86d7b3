//! VB: the walk about seven trees (2008: table 1, figures 6 and 7; 2007: figure 6), and table 1 of 2007.

use super::NamedPlot;
use super::report::{Row, Table};
use super::scenes::triangles;
use crate::falling::workload::{grove, grove_of, walkthrough};
use crate::harness::{FrameMeasurement, Harness, PlantedView, upload_models};
use crate::plot::{Line, Plot};
use crate::statistics::Quartiles;
use std::sync::Arc;
use windfall_core::path::PathSet;
use windfall_gpu::Falls;
use windfall_host::device::Gpu;
use windfall_papers::{
    Elimination, LandingSearch, LeafOcclusion, ListOptions, PassOptions, PathData, PublishedFalls,
    PublishedPasses, Strategy,
};
use windfall_scenes::Stage;

/// Frames of the walk, 30 a second.
const FRAMES: u32 = 3000;
/// Leaves thrown along it.
const THROWN: f32 = 12_000.0;
/// Leaves that elimination tests in a frame (VB 5: 10 to 20).
const TESTED: u32 = 20;

/// What draws the loose leaves.
#[derive(Clone, Copy)]
struct Method {
    name: &'static str,
    /// `None`: the renderer's compute path.
    strategy: Option<Strategy>,
    elimination: bool,
    occlusion: bool,
    paths: PathData,
}

const fn method(
    name: &'static str,
    strategy: Option<Strategy>,
    [elimination, occlusion]: [bool; 2],
) -> Method {
    Method { name, strategy, elimination, occlusion, paths: PathData::Table }
}

/// The published methods as they were published: landings are searched in the shader.
const METHODS: [Method; 7] = [
    method("vertex, no elimination", Some(Strategy::Vertex), [false, false]),
    method("vertex, elimination", Some(Strategy::Vertex), [true, false]),
    method("vertex, elimination, occlusion", Some(Strategy::Vertex), [true, true]),
    method("fragment, elimination, occlusion", Some(Strategy::Fragment), [true, true]),
    method("render to vertex, elimination", Some(Strategy::VertexBuffer), [true, false]),
    method("CPU, elimination", Some(Strategy::Cpu), [true, false]),
    method("compute (ours)", None, [true, false]),
];

impl Method {
    /// Plants a stage whose loose leaves it draws. `frames` of the walk pass between two that are measured.
    fn plant(
        self,
        gpu: &Gpu,
        harness: &Harness,
        (stage, models): (&Stage, &[windfall_gpu::TreeModel]),
        frames: u32,
    ) -> anyhow::Result<PlantedView> {
        let Some(strategy) = self.strategy else { return harness.plant(gpu, stage, models) };
        let capacity = stage.falls.capacity;
        let falls = Falls { capacity: 0, ..stage.falls.clone() };
        let mut planted = harness.plant(gpu, &Stage { falls, ..stage.clone() }, models)?;
        let occlusion = (self.occlusion && gpu.fragment_stores).then(LeafOcclusion::default);
        let (landing, paths) = (LandingSearch::InShader, self.paths);
        let options = PassOptions { strategy, landing, paths, occlusion };
        let passes = Arc::new(PublishedPasses::new(&gpu.device, options));
        let elimination = if self.elimination {
            // As many tests as the frames that are left out would have had.
            Elimination::Progressive { per_frame: TESTED * frames }
        } else {
            Elimination::Off
        };
        let options = ListOptions { capacity, elimination };
        let layer = PublishedFalls::new(&passes, &planted.stage.forest, options)?;
        planted.stage.published = Some(layer);
        Ok(planted)
    }
}

/// Frames of one method over the walk, and those without moving leaves that took turns with them.
struct Walk {
    name: &'static str,
    frames: Vec<FrameMeasurement>,
    still: Vec<FrameMeasurement>,
}

impl Walk {
    fn ms(frames: &[FrameMeasurement]) -> Vec<f64> {
        frames.iter().map(|m| m.wall_ms).collect()
    }

    /// Frame rate over that without moving leaves.
    fn rate(&self) -> f64 {
        let (with, without) = (Self::ms(&self.frames), Self::ms(&self.still));
        without.iter().sum::<f64>() / with.iter().sum::<f64>()
    }

    fn row(&self, name: &str, printed: Option<f64>) -> Row {
        let last = self.frames.last().map(|m| m.counts).unwrap_or_default();
        Row {
            name: name.to_owned(),
            ms: Quartiles::of(&Self::ms(&self.frames)),
            measured: Some(self.rate()),
            printed,
            notes: format!("at the end {} fall or wait, {} lie", last.falling, last.eliminated),
        }
    }
}

/// The walk with each method, and the tables and figures that are of it.
pub fn walk(
    gpu: &mut Gpu,
    quick: bool,
    number: usize,
    plots: &mut Vec<NamedPlot>,
) -> anyhow::Result<Vec<Table>> {
    let (size, samples) = if quick { ((320, 180), 12) } else { ((640, 360), 100) };
    let stride = FRAMES / samples;
    let harness = Harness::new(gpu, size)?;
    let mut stage = grove();
    stage.throw(THROWN * 30.0 / FRAMES as f32, 0.0);
    let models = upload_models(gpu, &stage)?;
    let bare = Stage { falls: Falls::none(), ..stage.clone() };
    let mut still = harness.plant(gpu, &bare, &models)?;
    let mut walks = Vec::new();
    for method in METHODS {
        println!("walk: {}", method.name);
        let mut planted = method.plant(gpu, &harness, (&stage, &models), stride)?;
        let mut of = Walk { name: method.name, frames: Vec::new(), still: Vec::new() };
        for sample in 0..=samples {
            let seconds = f64::from(sample * stride) / 30.0;
            let view = walkthrough(&stage, seconds);
            // The frame before it, so that the measured one has the changes of one frame.
            let before = (seconds - 1.0 / 30.0, &walkthrough(&stage, seconds - 1.0 / 30.0));
            harness.measure(gpu, &mut planted, before)?;
            let with = harness.measure(gpu, &mut planted, (seconds, &view))?;
            let without = harness.measure(gpu, &mut still, (seconds, &view))?;
            // At the first pipelines are compiled.
            if sample > 0 {
                of.frames.push(with);
                of.still.push(without);
            }
        }
        walks.push(of);
    }
    let find = |name: &str| walks.iter().find(|w| w.name == name);
    let scene = format!(
        "{samples} of {FRAMES} frames of a walk about 7 trees of {} thousand triangles at {}x{}; 12,000 leaves thrown \
         evenly; landings searched in the shader, elimination of {TESTED} leaves a frame",
        triangles(&stage) / 1000,
        size.0,
        size.1
    );
    let none = Row {
        name: "no leaves in movement".into(),
        ms: Quartiles::of(&walks.iter().flat_map(|w| Walk::ms(&w.still)).collect::<Vec<_>>()),
        measured: Some(1.0),
        printed: Some(1.0),
        notes: String::new(),
    };
    let rows = |names: &[(&str, &str, Option<f64>)]| {
        let of = names.iter().filter_map(|(method, name, printed)| {
            find(method).map(|walk| walk.row(name, *printed))
        });
        std::iter::once(none.clone()).chain(of).collect::<Vec<Row>>()
    };
    let file = |name: &str| format!("papers/{name}-{number}");
    let seconds = |i: usize| (i + 1) as f64 * f64::from(stride);
    let line = |name: &str, values: Vec<f64>| Line {
        name: name.to_owned(),
        points: values.into_iter().enumerate().map(|(i, v)| (seconds(i), v)).collect(),
    };
    let rates = |frames: &[FrameMeasurement]| {
        Walk::ms(frames).into_iter().map(|ms| 1e3 / ms).collect::<Vec<f64>>()
    };
    let mut lines: Vec<Line> = walks.iter().map(|w| line(w.name, rates(&w.frames))).collect();
    lines.extend(walks.first().map(|w| line("no leaves in movement", rates(&w.still))));
    let plot = |title: &str, y, lines| Plot {
        title: title.to_owned(),
        axes: ["frame", y],
        log: false,
        lines,
    };
    plots.push((file("walk"), plot("Frames per second over the walk", "frames/s", lines)));
    let figure7 = find("fragment, elimination, occlusion").map(|walk| {
        let count = |get: fn(&FrameMeasurement) -> u64| {
            walk.frames.iter().map(|m| get(m) as f64).collect::<Vec<f64>>()
        };
        let lines = vec![
            line("thrown", count(|m| m.counts.falling + m.counts.landed)),
            line("in the list", count(|m| m.counts.falling)),
            line("drawn of these", count(|m| m.counts.falling_drawn)),
        ];
        plot("Leaves thrown and drawn", "leaves", lines)
    });
    plots.extend(figure7.map(|plot| (file("leaves"), plot)));
    let half_seen = find("fragment, elimination, occlusion").map(|walk| {
        let sum = |get: fn(&FrameMeasurement) -> u64| walk.frames.iter().map(get).sum::<u64>();
        let drawn =
            sum(|m| m.counts.falling_drawn) as f64 / sum(|m| m.counts.falling).max(1) as f64;
        Row {
            measured: Some(drawn),
            printed: Some(0.5),
            ..walk.row("drawn of those in the list", None)
        }
    });
    Ok(vec![
        Table {
            id: "vb2008-table1".into(),
            title: "VB 2008, table 1 and figure 6: strategies over the walk".into(),
            scene: scene.clone(),
            ratio: "mean frame rate over that without leaves in movement".into(),
            rows: rows(&[
                ("vertex, elimination, occlusion", "vertex shader", Some(26.3 / 209.5)),
                ("fragment, elimination, occlusion", "fragment shader", Some(74.7 / 209.5)),
                ("render to vertex, elimination", "render to vertex", Some(51.5 / 209.5)),
                ("CPU, elimination", "CPU", None),
                ("compute (ours)", "compute (ours)", None),
            ]),
            remark: "The order of the paper, fragment before render to vertex before vertex, is a matter of how often a \
                     leaf is posed: once, once a vertex to a texture, once a vertex in each pass that draws it. On a \
                     software adapter the trees themselves take most of a frame, so that moving leaves cost a smaller \
                     share than on the paper's card, whose vertex units read textures slowly. The paper gives no number \
                     for the CPU but that more than 1,000 leaves are not interactive; one core of today poses all that are \
                     in the air in a few milliseconds, and where the adapter is the same processor nothing is cheaper."
                .into(),
            plot: Some(file("walk")),
        },
        Table {
            id: "vb2008-figure7".into(),
            title: "VB 2008, figure 7: leaves thrown and leaves drawn".into(),
            scene: scene.clone(),
            ratio: "leaves drawn over leaves in the list, fragment with leaf occlusion".into(),
            rows: half_seen.into_iter().collect(),
            remark: "Roughly half in the paper. The share follows from the walk: leaves are skipped that are out of the \
                     frustum or behind trees, and the camera here looks at the middle of the grove all the time. Leaves \
                     that do not show three pixels in a small picture are skipped too."
                .into(),
            plot: Some(file("leaves")),
        },
        Table {
            id: "vb2007-figure6".into(),
            title: "VB 2007, figure 6: optimizations of the vertex strategy".into(),
            scene,
            ratio: "mean frame rate over that without leaves in movement".into(),
            rows: rows(&[
                ("vertex, no elimination", "without optimizations", None),
                ("vertex, elimination", "with elimination", None),
                ("vertex, elimination, occlusion", "with elimination and occlusion", None),
            ]),
            remark: "The figure is a plot without numbers; its text says that the optimized version \"can even double the \
                     results\". Elimination brings what it brought then: leaves that lie are searched for in every frame \
                     otherwise. Leaf occlusion costs more than it saves wherever its row is below the one before it: a \
                     tested leaf is drawn a second time to count its pixels, and a skipped one saves only the \
                     rasterization of some pixels, because its vertices are still run."
                .into(),
            plot: Some(file("walk")),
        },
    ])
}

/// Section 3.3 of 2008: path data in two one-dimensional textures, and with all other tables in one.
pub fn path_data(gpu: &mut Gpu, quick: bool) -> anyhow::Result<Table> {
    let (size, frames, falling) =
        if quick { ((320, 180), 5, 2000) } else { ((640, 360), 15, 5000) };
    println!("section 3.3 of 2008");
    let harness = Harness::new(gpu, size)?;
    let mut stage = grove_of(4, 3000);
    // One path for all leaves.
    stage.falls.paths = PathSet::new(stage.falls.paths.paths()[..1].to_vec())?;
    stage.keep_falling(falling);
    let models = upload_models(gpu, &stage)?;
    let ways = [
        ("one two-dimensional texture with all tables", PathData::Table),
        ("two one-dimensional textures", PathData::OneDimensional),
    ];
    let mut planted = Vec::new();
    for (_, paths) in ways {
        let of = Method { paths, ..method("", Some(Strategy::Vertex), [true, false]) };
        planted.push(of.plant(gpu, &harness, (&stage, &models), 1)?);
    }
    let mut times = [Vec::new(), Vec::new()];
    let mut in_list = 0;
    for frame in 0..frames + 2 {
        let seconds = 8.0 + f64::from(frame) / 30.0;
        let view = walkthrough(&stage, seconds);
        for (planted, times) in planted.iter_mut().zip(&mut times) {
            let measured = harness.measure(gpu, planted, (seconds, &view))?;
            in_list = measured.counts.falling;
            // Pipelines are compiled at the first.
            if frame >= 2 {
                times.push(measured.wall_ms);
            }
        }
    }
    let times = times.map(|times| Quartiles::of(&times));
    let rows = ways.into_iter().zip(times).map(|((name, _), ms)| Row {
        name: name.into(),
        ms,
        measured: Some(times[0].median / ms.median),
        printed: None,
        notes: format!("{in_list} in the list"),
    });
    Ok(Table {
        id: "vb2008-3.3".into(),
        title: "VB 2008, section 3.3: where path data are".into(),
        scene: format!(
            "Strategy vertex, one path of {} samples, landings searched in the shader, elimination, {}x{}",
            stage.falls.paths.paths()[0].positions().len(),
            size.0,
            size.1
        ),
        ratio: "frame rate over one texture".into(),
        rows: rows.collect(),
        remark: "The paper has two one-dimensional textures and compares them with nothing. One texture needs a fetch for a \
                 sample instead of two and holds longer paths than a one-dimensional texture may; the paper's layout needs \
                 no unpacking."
            .into(),
        plot: None,
    })
}

/// Trees, leaves in the air and frames per second.
const TABLE_1: [(u32, u32, f64); 12] = [
    (1, 0, 36.97),
    (1, 1000, 34.4),
    (1, 2000, 31.88),
    (1, 5000, 28.09),
    (4, 0, 18.79),
    (4, 1000, 17.49),
    (4, 2000, 16.66),
    (4, 5000, 14.27),
    (6, 0, 10.9),
    (6, 1500, 10.04),
    (6, 3000, 9.56),
    (6, 6000, 8.63),
];

/// Table 1 of 2007: one, four and six trees of 128 thousand triangles.
pub fn table_of_2007(gpu: &mut Gpu, quick: bool) -> anyhow::Result<Table> {
    let (size, frames) = if quick { ((320, 256), 4) } else { ((1280, 1024), 15) };
    let harness = Harness::new(gpu, size)?;
    let mut rows = Vec::new();
    for trees in [1, 4, 6] {
        println!("table 1 of 2007: {trees} trees");
        let base = grove_of(trees, 8300);
        let models = upload_models(gpu, &base)?;
        let triangles = triangles(&base);
        let mut without = f64::NAN;
        for (_, leaves, printed) in TABLE_1.into_iter().filter(|row| row.0 == trees) {
            let mut stage = base.clone();
            let method = if leaves == 0 {
                stage.falls = Falls::none();
                method("", None, [false; 2])
            } else {
                stage.keep_falling(leaves);
                method("", Some(Strategy::Vertex), [true, true])
            };
            let mut planted = method.plant(gpu, &harness, (&stage, &models), 1000)?;
            let (mut ms, mut falling) = (Vec::new(), 0);
            for frame in 0..frames + 3 {
                let seconds = 1.0 + f64::from(frame) / 30.0;
                let view = walkthrough(&stage, seconds);
                let measured = harness.measure(gpu, &mut planted, (seconds, &view))?;
                if frame >= 3 {
                    ms.push(measured.wall_ms);
                }
                falling = measured.counts.falling;
            }
            let ms = Quartiles::of(&ms);
            if leaves == 0 {
                without = ms.median;
            }
            let first = TABLE_1.iter().find(|row| row.0 == trees).map_or(f64::NAN, |row| row.2);
            rows.push(Row {
                name: format!("{trees} trees, {leaves} leaves"),
                ms,
                measured: Some(without / ms.median),
                printed: Some(printed / first),
                notes: format!("{falling} in the air, {}K triangles", triangles / 1000),
            });
        }
    }
    Ok(Table {
        id: "vb2007-table1".into(),
        title: "VB 2007, table 1: trees and leaves".into(),
        scene: format!(
            "Frames of the walk at {}x{}, strategy vertex with elimination and occlusion",
            size.0, size.1
        ),
        ratio: "frame rate over that without falling leaves".into(),
        rows,
        remark: "Differs: the paper gives up some 20% for 5,000 leaves, here it is more than half. A software adapter runs \
                 vertices on the same cores as all else, a bare leaf has several times the paper's 6 triangles near the \
                 camera, each of its vertices poses the leaf again, and leaf occlusion draws tested leaves twice. What \
                 agrees is that the share falls as trees are added. \"In the air\" has those that lie and wait for \
                 elimination."
            .into(),
        plot: None,
    })
}
