//! Which node is the leaf, and which animation ("take") moves it.

use super::super::{ImportOptions, NoteCode, Notes};
use gltf::animation::{Channel, Property};
use gltf::{Animation, Document, Node};
use std::collections::BTreeSet;
use windfall_core::{InputError, InputErrorKind};

/// More moving parents than any rig of a leaf has; a bound on the work that a small file can ask for.
const MOST_PARENTS: usize = 64;

/// One animation of one leaf.
pub(super) struct Take<'a> {
    pub node: Node<'a>,
    /// The nodes above, the nearest first.
    pub parents: Vec<Node<'a>>,
    document: &'a Document,
    animation: usize,
    /// Nodes above that the animation moves, turns or scales.
    moving: BTreeSet<usize>,
}

/// What errors call a node.
pub(super) fn label(node: &Node) -> String {
    node.name().map_or(format!("node {}", node.index()), |n| format!("node \"{n}\""))
}

/// What lists call a node or an animation.
fn listed(name: Option<&str>, index: usize) -> String {
    name.map_or(format!("{index} (unnamed)"), str::to_owned)
}

fn moves(channel: &Channel) -> bool {
    matches!(channel.target().property(), Property::Translation | Property::Rotation)
}

impl<'a> Take<'a> {
    /// Chooses node and animation as the options say, or the only ones there are.
    pub fn choose(
        file: &str,
        document: &'a Document,
        options: &ImportOptions,
        notes: &mut Notes<'_>,
    ) -> Result<Self, InputError> {
        let named = match &options.animation {
            Some(name) => Some(named_animation(file, document, name)?),
            None => None,
        };
        let parent_of = parents(document);
        let node = choose_node(file, document, named, &parent_of, options)?;
        let chain: Vec<usize> = above(&parent_of, node.index()).collect();
        let links: BTreeSet<usize> = chain.iter().copied().collect();
        if links.len() < chain.len() {
            let cause = "it is among its own parents";
            return Err(InputError::new(file, label(&node), InputErrorKind::Malformed, cause));
        }
        let in_chain = |c: &Channel| links.contains(&c.target().node().index()) && moves(c);

        let takes: Vec<Animation> =
            document.animations().filter(|a| a.channels().any(|c| in_chain(&c))).collect();
        let falls = |a: &Animation| {
            a.channels().any(|c| in_chain(&c) && c.target().property() == Property::Translation)
        };
        let first = || takes.iter().find(|a| falls(a)).or(takes.first()).map(Animation::index);
        // The node was found in an animation.
        let animation = named.or_else(first).unwrap_or(0);
        if named.is_none() && takes.len() > 1 {
            let name = |a: &Animation| listed(a.name(), a.index());
            let others = takes.iter().filter(|a| a.index() != animation).map(name);
            let taken = takes.iter().find(|a| a.index() == animation).map(name);
            let message = format!(
                "is in {} animations: {} is taken, choose with --animation; the others are: {}",
                takes.len(),
                taken.unwrap_or_default(),
                others.collect::<Vec<_>>().join(", ")
            );
            notes.add(NoteCode::OtherTakes, &label(&node), message);
        }
        let mut parents = Vec::new();
        for &index in &chain[1..] {
            parents.extend(document.nodes().nth(index));
        }
        let mut take = Self { node, parents, document, animation, moving: BTreeSet::new() };
        let targets: BTreeSet<usize> = take
            .channels()
            .filter(|c| c.target().property() != Property::MorphTargetWeights)
            .map(|c| c.target().node().index())
            .collect();
        take.moving = chain[1..].iter().copied().filter(|i| targets.contains(i)).collect();
        if take.moving.len() > MOST_PARENTS {
            let cause = format!(
                "{} of its parents are animated; bake the motion into one node",
                take.moving.len()
            );
            return Err(InputError::new(
                file,
                label(&take.node),
                InputErrorKind::Unsupported,
                cause,
            ));
        }
        Ok(take)
    }

    fn channels(&self) -> impl Iterator<Item = Channel<'a>> + use<'a> {
        let animation = self.animation;
        self.document
            .animations()
            .filter(move |a| a.index() == animation)
            .flat_map(|a| a.channels())
    }

    /// The channel of a node's property, if the animation has one.
    pub fn channel(&self, node: usize, property: Property) -> Option<Channel<'a>> {
        self.channels()
            .find(|c| c.target().node().index() == node && c.target().property() == property)
    }

    /// Nodes above that move, the nearest first.
    pub fn moving_parents(&self) -> impl Iterator<Item = &Node<'a>> {
        self.parents.iter().filter(|p| self.moving.contains(&p.index()))
    }

    /// That nothing moves the leaf; names what moves it in another take.
    pub fn no_translation(&self, file: &str) -> InputError {
        let elsewhere = self.document.animations().find_map(|a| {
            let channel = a.channels().find(|c| {
                let node = c.target().node().index();
                c.target().property() == Property::Translation
                    && self.parents.iter().any(|p| p.index() == node)
            })?;
            Some((label(&channel.target().node()), listed(a.name(), a.index())))
        });
        let cause = match elsewhere {
            Some((parent, animation)) => format!(
                "no translation channel; its parent, {parent}, is moved by another animation, {animation}: \
                 bake both into one"
            ),
            None => "no translation channel".to_owned(),
        };
        InputError::new(file, label(&self.node), InputErrorKind::Missing, cause)
    }
}

fn named_animation(file: &str, document: &Document, name: &str) -> Result<usize, InputError> {
    let animations = || document.animations();
    let by_number = || animations().find(|a| a.name().is_none() && a.index().to_string() == name);
    if let Some(found) = animations().find(|a| a.name() == Some(name)).or_else(by_number) {
        return Ok(found.index());
    }
    let names: Vec<String> = animations().map(|a| listed(a.name(), a.index())).collect();
    let cause = if names.is_empty() {
        "no node is animated: there is no path in it".to_owned()
    } else {
        format!("no animation is called \"{name}\"; there are: {}", names.join(", "))
    };
    Err(InputError::new(file, "animations", InputErrorKind::Missing, cause))
}

/// The parent of each node; the last to claim a child has it.
fn parents(document: &Document) -> Vec<Option<usize>> {
    let mut parents = vec![None; document.nodes().len()];
    for node in document.nodes() {
        for child in node.children() {
            parents[child.index()] = Some(node.index());
        }
    }
    parents
}

/// A node and those above it. A file may claim a circle: then one of them comes twice.
fn above(parents: &[Option<usize>], node: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(node), |&n| parents[n]).take(parents.len() + 1)
}

/// The node that is named, or the only one that is animated, or the lowest where each is the parent of the next.
fn choose_node<'a>(
    file: &str,
    document: &'a Document,
    animation: Option<usize>,
    parents: &[Option<usize>],
    options: &ImportOptions,
) -> Result<Node<'a>, InputError> {
    let mut animated: Vec<Node> = Vec::new();
    let mut seen = BTreeSet::new();
    for take in document.animations().filter(|a| animation.is_none_or(|i| a.index() == i)) {
        for channel in take.channels().filter(moves) {
            let node = channel.target().node();
            if seen.insert(node.index()) {
                animated.push(node);
            }
        }
    }
    let names =
        || animated.iter().map(|n| n.name().unwrap_or("(unnamed)")).collect::<Vec<_>>().join(", ");
    let refuse = |kind, cause: String| Err(InputError::new(file, "animations", kind, cause));
    if animated.is_empty() {
        return refuse(InputErrorKind::Empty, "no node is animated: there is no path in it".into());
    }
    if let Some(name) = &options.node {
        let called = |n: &Node| n.name() == Some(name);
        let carried = || {
            document
                .nodes()
                .find(|n| called(n) && above(parents, n.index()).any(|p| seen.contains(&p)))
        };
        return match animated.iter().find(|n| called(n)).cloned().or_else(carried) {
            Some(node) => Ok(node),
            None => refuse(
                InputErrorKind::Missing,
                format!("no animated node is called \"{name}\"; animated are: {}", names()),
            ),
        };
    }
    // The lowest of a chain has all others above it.
    let others = animated.len() - 1;
    let lowest = animated.iter().filter(|_| others <= MOST_PARENTS).find(|n| {
        above(parents, n.index())
            .skip(1)
            .filter(|p| seen.contains(p))
            .collect::<BTreeSet<_>>()
            .len()
            == others
    });
    match lowest {
        Some(node) => Ok(node.clone()),
        None => refuse(
            InputErrorKind::Unsupported,
            format!("{} nodes are animated; name one with --node: {}", animated.len(), names()),
        ),
    }
}
