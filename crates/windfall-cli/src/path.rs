//! `windfall path`: fall paths.

/// Arguments of `windfall path`.
#[derive(clap::Args)]
pub struct Args {}

/// Runs `windfall path`.
pub fn run(_args: Args) -> anyhow::Result<()> {
    Ok(())
}
