//! `windfall bench papers`: the tables and figures of the papers from one command, each beside what is printed.

mod area;
pub mod compare;
mod falling;
mod limits;
mod pictures;
mod report;
mod scenes;
mod simplified;
mod submission;

use crate::output::{create_folder, write_json, write_text};
use crate::plot::Plot;
use report::{AdapterReport, Report, Table};
use std::path::{Path, PathBuf};
use windfall_host::device::Gpu;

/// Arguments of `windfall bench papers`.
#[derive(clap::Args)]
pub struct Args {
    /// Fewer and smaller frames: some minutes on a software adapter
    #[arg(long)]
    quick: bool,
    /// Folder for report.md, report.json and the plots (in papers/)
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// A plot and the name of its files without their endings, below the folder of the report.
type NamedPlot = (String, Plot);

/// Runs `windfall bench papers`: on every adapter that there is, or on the one of `WGPU_ADAPTER_NAME`.
pub fn run(args: &Args) -> anyhow::Result<()> {
    create_folder(&args.out.join("papers"))?;
    let mut report = Report {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        quick: args.quick,
        adapters: Vec::new(),
    };
    Gpu::for_each(|mut gpu| {
        let number = report.adapters.len();
        let (mut tables, plots) = measure(&mut gpu, args.quick, number)?;
        for (name, plot) in plots {
            write_text(&args.out.join(format!("{name}.svg")), &plot.svg()?)?;
            plot.save_png(&args.out.join(format!("{name}.png")))?;
        }
        let mut figures = pictures::draw(&mut gpu, &args.out, number)?;
        let (scenes, of_scenes) = scenes::measure(&mut gpu, args.quick, &args.out, number)?;
        tables.push(scenes);
        figures.extend(of_scenes);
        let (adapter, driver) = (gpu.adapter.clone(), gpu.driver.clone());
        report.adapters.push(AdapterReport { adapter, driver, tables, figures });
        // After each adapter: what is measured is not lost if the next one fails.
        write(&args.out, &report)
    })
}

fn write(folder: &Path, report: &Report) -> anyhow::Result<()> {
    write_json(&folder.join("report.json"), report)?;
    write_text(&folder.join("report.md"), &report.markdown())
}

/// All tables of an adapter.
fn measure(
    gpu: &mut Gpu,
    quick: bool,
    number: usize,
) -> anyhow::Result<(Vec<Table>, Vec<NamedPlot>)> {
    println!("{}, {}", gpu.adapter, gpu.driver);
    let mut plots = Vec::new();
    let mut tables = vec![limits::measure(gpu, quick)?];
    tables.extend(falling::walk(gpu, quick, number, &mut plots)?);
    tables.push(falling::path_data(gpu, quick)?);
    tables.push(falling::table_of_2007(gpu, quick)?);
    tables.extend(simplified::measure(gpu, quick, number, &mut plots)?);
    tables.push(area::table(quick));
    tables.push(submission::table(gpu, quick)?);
    Ok((tables, plots))
}
