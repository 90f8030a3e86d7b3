//! Options of every command that reads a tree file, and the notes on files.

use std::io::Write;
use windfall_core::Note;
use windfall_tree::{ImportOptions, Up};

/// How a tree file is read.
#[derive(clap::Args, Clone)]
pub struct ReadArgs {
    /// Node of the file to read, by name or number, with all below it; may be given again
    #[arg(long, value_name = "NAME|N", requires = "tree")]
    pub node: Vec<String>,
    /// What is leaves: the name of a node, mesh or material, or the number of a primitive; may be given again
    #[arg(long, value_name = "NAME|N", requires = "tree")]
    pub leaves: Vec<String>,
    /// Axis that points up in the file: y or z
    #[arg(long, value_name = "AXIS", value_enum, default_value_t = UpArg::Y, hide_possible_values = true, requires = "tree")]
    pub up: UpArg,
    /// Metres for each unit of the file, such as 0.01 for centimetres
    #[arg(long, value_name = "M", requires = "tree")]
    pub unit: Option<f32>,
    /// Put the lowest point of the tree on the ground
    #[arg(long, requires = "tree")]
    pub ground: bool,
    /// Whether colours of vertices are colours: off where they are weights of the wind
    #[arg(long, value_name = "on|off", value_parser = parse_switch, default_value = "on", requires = "tree")]
    pub vertex_colors: Switch,
    /// Scale the tree to this height, metres
    #[arg(long, value_name = "M", requires = "tree")]
    pub height: Option<f32>,
}

/// `on` or `off`.
pub type Switch = bool;

/// The axis that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum UpArg {
    Y,
    Z,
}

impl From<UpArg> for Up {
    fn from(up: UpArg) -> Self {
        match up {
            UpArg::Y => Self::Y,
            UpArg::Z => Self::Z,
        }
    }
}

impl ReadArgs {
    /// The importer's options. `wood` is what is wood, by name or number.
    pub fn options(&self, wood: &[String]) -> ImportOptions {
        ImportOptions {
            node: self.node.clone(),
            leaves: self.leaves.clone(),
            wood: wood.to_vec(),
            up: self.up.into(),
            unit: self.unit,
            ground: self.ground,
            vertex_colors: self.vertex_colors,
            height: self.height,
            ..ImportOptions::default()
        }
    }
}

/// Reads `on` or `off`.
pub fn parse_switch(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("is neither on nor off".to_owned()),
    }
}

/// Prints notes on stderr, a line each.
pub fn print_notes(notes: &[Note]) {
    let mut out = std::io::stderr().lock();
    for note in notes {
        // Nobody is there to tell that stderr is closed.
        let _ = writeln!(out, "{note}");
    }
}
