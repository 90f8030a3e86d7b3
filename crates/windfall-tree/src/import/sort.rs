//! Which primitives are leaves, which are wood, and which are left out.

use super::document::Primitive;
use super::name::{key, listed, quoted, words};
use super::{ImportOptions, Reader};
use glam::DMat4;
use std::collections::BTreeSet;
use std::fmt::Write;
use windfall_core::InputErrorKind::{Empty, Missing};
use windfall_core::{InputError, NoteCode};

/// Primitives that an error lists before it only counts them.
const MOST_LISTED: usize = 40;

/// What a primitive is taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Use {
    /// Leaves.
    Leaves,
    /// Wood.
    Wood,
    /// Neither: it is left out.
    LeftOut,
}

/// A primitive as a node draws it.
pub(super) struct Found<'a> {
    /// Its number, for people to choose by.
    pub number: usize,
    /// Where in the file: `mesh 1 "leaves", primitive 0`.
    pub place: String,
    pub node: Option<&'a str>,
    pub node_index: usize,
    pub mesh: Option<&'a str>,
    pub material: Option<&'a str>,
    /// Whether the material has alpha that is used.
    pub masked: bool,
    /// Triangles of each of its instances.
    pub triangles: u64,
    pub primitive: &'a Primitive,
    /// Numbers of the mesh, and of the primitive in it.
    pub key: (usize, usize),
    /// From the primitive to the tree, before the place far from the origin is taken off: one for each instance.
    pub transforms: Vec<DMat4>,
    pub skin: Option<usize>,
    /// Weights of morph targets.
    pub weights: &'a [f32],
    /// What [`sort`] decides, and why.
    pub use_as: Option<Use>,
    pub why: String,
}

impl Found<'_> {
    pub fn is(&self, what: Use) -> bool {
        self.use_as == Some(what)
    }

    /// Why the material says that these are leaves.
    fn by_material(&self) -> Option<String> {
        let like = |test: fn(&str) -> bool| self.material.is_some_and(test);
        if like(is_leafy) {
            return Some(format!("material {}", quoted(self.material.unwrap_or_default())));
        }
        (self.masked && !like(is_woody)).then(|| "its material is alpha-masked".to_string())
    }

    /// Why the node or the mesh say so.
    fn by_name(&self) -> Option<String> {
        let named = |kind: &str, name: Option<&str>| {
            name.filter(|name| is_leafy(name)).map(|name| format!("{kind} {}", quoted(name)))
        };
        named("node", self.node).or_else(|| named("mesh", self.mesh))
    }
}

/// The primitives that a choice means: by the name of node, mesh or material, else by number.
fn chosen(found: &[Found<'_>], choice: &str) -> Vec<usize> {
    let wanted = key(choice);
    let is = |name: Option<&str>| name.is_some_and(|own| key(own) == wanted);
    let named =
        found.iter().filter(|f| [f.node, f.mesh, f.material].into_iter().any(is)).map(|f| f.number);
    let named: Vec<usize> = named.collect();
    if !named.is_empty() {
        return named;
    }
    let number = choice.parse().ok().filter(|&number: &usize| number < found.len());
    number.into_iter().collect()
}

/// Decides which primitives are leaves and which wood: as the options say, or as it looks.
pub(super) fn sort(
    found: &mut [Found<'_>],
    options: &ImportOptions,
    reader: &mut Reader<'_>,
) -> Result<(), InputError> {
    let file = reader.file;
    let mut set = |choices: &[String], what: Use| {
        for choice in choices {
            let numbers = chosen(found, choice);
            if numbers.is_empty() {
                let cause = format!(
                    "no primitive has that number, and no node, mesh or material is named {}",
                    quoted(choice)
                );
                return Err(no_leaves(found, file, Missing, &cause));
            }
            for number in numbers {
                found[number].use_as = Some(what);
                found[number].why = format!("chosen by {}", quoted(choice));
            }
        }
        Ok(())
    };
    set(&options.leaves, Use::Leaves)?;
    set(&options.wood, Use::Wood)?;
    let rest = match (options.leaves.is_empty(), options.wood.is_empty()) {
        (true, true) => None,
        (false, true) => Some(Use::Wood),
        (true, false) => Some(Use::Leaves),
        (false, false) => Some(Use::LeftOut),
    };
    if let Some(rest) = rest {
        let mut left_out = Vec::new();
        for part in found.iter_mut().filter(|part| part.use_as.is_none()) {
            (part.use_as, part.why) = (Some(rest), "not chosen".to_string());
            if rest == Use::LeftOut {
                left_out.push(format!("primitive {} of {}", part.number, part.place));
            }
        }
        if !left_out.is_empty() {
            let message = format!("neither leaves nor wood: {}", listed(&left_out));
            reader.note(NoteCode::PrimitiveLeftOut, "", message);
        }
    } else {
        // A node "tree with leaves" may hold bark too: its name tells only where materials do not.
        let told: BTreeSet<usize> =
            found.iter().filter(|f| f.by_material().is_some()).map(|f| f.node_index).collect();
        for part in found.iter_mut() {
            let by_name = part.by_name().filter(|_| !told.contains(&part.node_index));
            (part.use_as, part.why) = match part.by_material().or(by_name) {
                Some(why) => (Some(Use::Leaves), why),
                None => (Some(Use::Wood), "nothing says that it is leaves".to_string()),
            };
        }
    }
    if found.iter().any(|f| f.is(Use::Leaves)) {
        return Ok(());
    }
    let cause = "nothing is named like leaves, and no material is alpha-masked";
    Err(no_leaves(found, file, Empty, cause))
}

/// The error for a tree without leaves: what there is, and how to say which of it are leaves.
pub(super) fn no_leaves(
    found: &[Found<'_>],
    file: &str,
    kind: windfall_core::InputErrorKind,
    why: &str,
) -> InputError {
    let mut cause = format!("no leaves: {why}. The primitives are:\n");
    let name = |name: Option<&str>| name.map_or("(unnamed)".to_string(), quoted);
    for part in found.iter().take(MOST_LISTED) {
        let _ = write!(
            cause,
            "  {}: node {}, mesh {}, material {}: {} triangles",
            part.number,
            name(part.node),
            name(part.mesh),
            name(part.material),
            part.triangles
        );
        let _ = match part.transforms.len() {
            1 => writeln!(cause),
            many => writeln!(cause, ", {many} times"),
        };
    }
    if found.len() > MOST_LISTED {
        let _ = writeln!(cause, "  and {} more", found.len() - MOST_LISTED);
    }
    cause += "Say which of them are leaves with --leaves NAME: the name of a node, mesh or material, or the \
              number of a primitive.";
    InputError::new(file, "", kind, cause)
}

/// Whether a name speaks of leaves: "Leaves", "oak_leaf.001", "TreeLeaves", "oakleaves".
fn is_leafy(name: &str) -> bool {
    const WORDS: [&str; 10] = [
        "leaf", "leafs", "leaves", "leaflet", "leaflets", "foliage", "frond", "fronds", "needle",
        "needles",
    ];
    words(name).iter().any(|word| {
        WORDS.iter().any(|leaf| word.ends_with(leaf))
            || ["leafcard", "leafmat", "leavesmat"].iter().any(|start| word.starts_with(start))
    })
}

/// Whether a name speaks of a single leaf: "leaf.012".
pub(super) fn words_say_leaf(name: &str) -> bool {
    words(name).iter().any(|word| word == "leaf" || word == "leaflet")
}

fn is_woody(name: &str) -> bool {
    const WORDS: [&str; 8] =
        ["bark", "trunk", "branch", "branches", "wood", "stem", "twig", "twigs"];
    words(name).iter().any(|word| WORDS.contains(&word.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_leaves_are_known_by_their_words() {
        for name in
            ["leaves", "Leaf", "oak_leaf.001", "TreeLeaves", "LEAVES_LOD0", "oakleaves", "Needles2"]
        {
            assert!(is_leafy(name), "{name}");
        }
        for name in ["leafless", "tree", "relief", "cleave", "bark", ""] {
            assert!(!is_leafy(name), "{name}");
        }
    }
}
