//! Which primitives are leaves.

use super::document::Primitive;
use super::quoted;
use glam::Mat4;
use std::collections::BTreeSet;
use std::fmt::Write;
use windfall_core::InputError;
use windfall_core::InputErrorKind::Empty;

/// Primitives that an error lists before it only counts them.
const MOST_LISTED: usize = 40;

/// A primitive as a node draws it.
pub(super) struct Found<'a> {
    /// Where in the file: `mesh 1 "leaves", primitive 0`.
    pub place: String,
    pub node: Option<&'a str>,
    pub node_index: usize,
    pub mesh: Option<&'a str>,
    pub material: Option<&'a str>,
    /// Whether the material has alpha that is used.
    pub masked: bool,
    pub triangles: u64,
    pub primitive: &'a Primitive,
    pub world_from_node: Mat4,
    /// Whether these are leaves: what [`sort`] decides.
    pub leaves: bool,
}

impl Found<'_> {
    fn by_material(&self) -> bool {
        let like = |test: fn(&str) -> bool| self.material.is_some_and(test);
        like(is_leafy) || (self.masked && !like(is_woody))
    }

    fn is_named(&self, name: &str) -> bool {
        [self.node, self.mesh, self.material]
            .into_iter()
            .flatten()
            .any(|own| own.to_lowercase() == name.to_lowercase())
    }
}

/// Decides which primitives are leaves: those that `names` say, or those that look like it.
pub(super) fn sort(
    found: &mut [Found<'_>],
    names: &[String],
    file: &str,
) -> Result<(), InputError> {
    if let Some(name) = names.iter().find(|name| !found.iter().any(|f| f.is_named(name))) {
        let cause = format!("no node, mesh or material is named {}", quoted(name));
        return Err(no_leaves(found, file, &cause));
    }
    if names.is_empty() {
        // A node "tree with leaves" may hold bark too: its name tells only where materials do not.
        let told: BTreeSet<usize> =
            found.iter().filter(|f| f.by_material()).map(|f| f.node_index).collect();
        for part in found.iter_mut() {
            let by_name = [part.node, part.mesh].into_iter().flatten().any(is_leafy)
                && !told.contains(&part.node_index);
            part.leaves = part.by_material() || by_name;
        }
    } else {
        for part in found.iter_mut() {
            part.leaves = names.iter().any(|name| part.is_named(name));
        }
    }
    if found.iter().any(|f| f.leaves) {
        return Ok(());
    }
    let cause = "nothing is named like leaves, and no material is alpha-masked";
    Err(no_leaves(found, file, cause))
}

/// The error for a tree without leaves: what there is, and how to say which of it are leaves.
pub(super) fn no_leaves(found: &[Found<'_>], file: &str, why: &str) -> InputError {
    let mut cause = format!("no leaves: {why}. The primitives are:\n");
    let name = |name: Option<&str>| name.map_or("(unnamed)".to_string(), quoted);
    for part in found.iter().take(MOST_LISTED) {
        let _ = writeln!(
            cause,
            "  node {}, mesh {}, material {}: {} triangles",
            name(part.node),
            name(part.mesh),
            name(part.material),
            part.triangles
        );
    }
    if found.len() > MOST_LISTED {
        let _ = writeln!(cause, "  and {} more", found.len() - MOST_LISTED);
    }
    cause +=
        "Say which of them are leaves with --leaves NAME, the name of a node, mesh or material.";
    InputError::new(file, "", Empty, cause)
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

fn is_woody(name: &str) -> bool {
    const WORDS: [&str; 8] =
        ["bark", "trunk", "branch", "branches", "wood", "stem", "twig", "twigs"];
    words(name).iter().any(|word| WORDS.contains(&word.as_str()))
}

/// The words of a name, in lower case: parted by anything but letters, and where a capital follows
/// a small letter.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for letter in name.chars() {
        if !letter.is_alphabetic() || (before.is_lowercase() && letter.is_uppercase()) {
            words.push(String::new());
        }
        if letter.is_alphabetic()
            && let Some(word) = words.last_mut()
        {
            word.extend(letter.to_lowercase());
        }
        before = letter;
    }
    words
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
