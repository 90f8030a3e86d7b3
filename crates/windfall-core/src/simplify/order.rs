//! Names of prune orders: which leaves a simplified tree keeps. The crate `windfall-tree` makes them.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// How the leaves of a tree are ordered for simplification, which draws the first of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(try_from = "String", into = "&'static str")]
pub enum PruneOrder {
    /// By chance (SFS, 3.2).
    Random,
    /// Those first of which most is seen from outside (SFS, 3.2 and 6).
    Importance,
    /// The default. Every prefix is spread as the whole crown is: progressive blue noise that keeps to the crown's
    /// own density. By sample elimination (C. Yuksel, "Sample Elimination for Generating Poisson Disk
    /// Sample Sets", Computer Graphics Forum 34(2), 2015) from the whole crown to half of it, from
    /// that to a quarter, and so on; beyond Yuksel, of each pair of neighbours exactly one goes, or
    /// dense twigs would be thinned more than sparse ones.
    #[default]
    BlueNoise,
}

impl PruneOrder {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Random, Self::Importance, Self::BlueNoise];

    /// Its name on command lines and in scene files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Importance => "importance",
            Self::BlueNoise => "blue-noise",
        }
    }
}

impl fmt::Display for PruneOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no prune order has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("prune order {0:?} is not known; there are: {names}", names = PruneOrder::ALL.map(PruneOrder::name).join(", "))]
pub struct UnknownPruneOrder(
    /// The name as given.
    pub String,
);

impl FromStr for PruneOrder {
    type Err = UnknownPruneOrder;

    fn from_str(name: &str) -> Result<Self, UnknownPruneOrder> {
        Self::ALL
            .into_iter()
            .find(|order| order.name() == name)
            .ok_or_else(|| UnknownPruneOrder(name.to_owned()))
    }
}

impl TryFrom<String> for PruneOrder {
    type Error = UnknownPruneOrder;

    /// The order of a name that was read from a file.
    fn try_from(name: String) -> Result<Self, UnknownPruneOrder> {
        name.parse()
    }
}

impl From<PruneOrder> for &'static str {
    fn from(order: PruneOrder) -> Self {
        order.name()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scene_files_and_command_lines_know_these_names() {
        for (name, order) in [
            ("random", PruneOrder::Random),
            ("importance", PruneOrder::Importance),
            ("blue-noise", PruneOrder::BlueNoise),
        ] {
            assert_eq!((name.parse(), order.to_string().as_str()), (Ok(order), name));
        }
        let error = "pink".parse::<PruneOrder>().unwrap_err().to_string();
        assert!(error.contains("\"pink\"") && error.contains("blue-noise"), "{error}");
    }
}
