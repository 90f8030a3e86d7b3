//! Temporary: the command line of `windfall bench`.
use clap::Parser;
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    args: windfall_bench::Args,
}
fn main() -> anyhow::Result<()> {
    windfall_bench::run(&Cli::parse().args)
}
