//! What the pieces of leaf primitives are: leaves, wood that shares their primitive, or whole crowns.

use super::primitive::Geometry;
use super::slots::Slots;
use super::sort::{Found, Use, words_say_leaf};
use super::{ImportOptions, Reader};
use crate::leaves::{Mesh, Pieces};
use glam::{DVec3, Vec2, Vec3};
use std::collections::BTreeSet;
use std::rc::Rc;
use windfall_core::material::Mask;
use windfall_core::{InputError, NoteCode};

/// Draws of leaf nodes from which on nodes may be the leaves.
const MANY_NODES: usize = 16;
/// Most pieces of a node that is a leaf: blade, stalk, and what else there may be.
const MOST_PIECES: usize = 4;
/// A piece so many times as large as the middle one is no leaf like the others.
const LARGE: f32 = 4.0;

/// What a piece is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    Leaf,
    Wood,
    /// A closed solid, as the crowns of low-poly trees are.
    Crown,
}

/// The primitives of which each node, or instance, is one leaf: there are many, each of a few unlike pieces close
/// together, or they are called a leaf.
pub(super) fn nodes_are_leaves(
    reader: &mut Reader<'_>,
    found: &[Found<'_>],
    read: &[(usize, Rc<Geometry>)],
) -> Result<BTreeSet<usize>, InputError> {
    let leafy = || read.iter().filter(|(number, _)| found[*number].is(Use::Leaves));
    let mut joined = BTreeSet::new();
    let draws: usize = leafy().map(|(number, _)| found[*number].transforms.len()).sum();
    if draws < MANY_NODES {
        return Ok(joined);
    }
    let mut known: Vec<((usize, usize), bool)> = Vec::new();
    for (number, geometry) in leafy() {
        let part = &found[*number];
        let of_mesh = known.iter().rev().take(8).find(|(key, _)| *key == part.key);
        let is = if let Some(known) = of_mesh {
            known.1
        } else {
            let origin = geometry.first(part.transforms[0]).unwrap_or(DVec3::ZERO);
            let mesh = reader.placed(geometry, part.transforms[0], origin, &part.place)?;
            let named = [part.node, part.mesh].into_iter().flatten().any(words_say_leaf);
            let is = mesh.leaves.is_empty() && is_one_leaf(&Pieces::cut(mesh), named);
            known.push((part.key, is));
            is
        };
        if is {
            joined.insert(*number);
        }
    }
    let of_joined: usize = joined.iter().map(|&number| found[number].transforms.len()).sum();
    if of_joined < MANY_NODES {
        return Ok(BTreeSet::new());
    }
    let message = format!(
        "{of_joined} nodes or instances are one leaf each, though the pieces of each share no edge"
    );
    reader.note(NoteCode::NodesAsLeaves, "", message);
    Ok(joined)
}

fn is_one_leaf(pieces: &Pieces, named: bool) -> bool {
    if !(2..=MOST_PIECES).contains(&pieces.len()) {
        return false;
    }
    let sizes: Vec<f32> = (0..pieces.len()).map(|i| diagonal(pieces.bounds(i))).collect();
    let (small, large) =
        sizes.iter().fold((f32::INFINITY, 0.0f32), |(l, h), &s| (l.min(s), h.max(s)));
    let counts: BTreeSet<usize> = (0..pieces.len()).map(|i| pieces.corners(i).len()).collect();
    let unlike = counts.len() > 1 || large > 1.5 * small;
    let close = diagonal(pieces.mesh.bounds()) <= 2.5 * large;
    close && (unlike || named)
}

/// Decides about every piece of the leaf primitives.
pub(super) fn judge(
    reader: &mut Reader<'_>,
    found: &[Found<'_>],
    leaves: &[(usize, Pieces)],
    wood: &[(usize, Mesh)],
    slots: &Slots,
    options: &ImportOptions,
) -> Vec<Vec<Verdict>> {
    let bounds = leaves.iter().map(|(_, pieces)| pieces.mesh.bounds());
    let (low, high) = bounds
        .chain(wood.iter().map(|(_, mesh)| mesh.bounds()))
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), (a, b)| (l.min(a), h.max(b)));
    let tree = Extent { foot: low.y, height: (high.y - low.y).max(f32::MIN_POSITIVE) };
    let mut verdicts: Vec<Vec<Verdict>> =
        leaves.iter().map(|(_, pieces)| vec![Verdict::Leaf; pieces.len()]).collect();

    let mut crowns = 0;
    for ((_, pieces), verdicts) in leaves.iter().zip(&mut verdicts) {
        for (i, verdict) in verdicts.iter_mut().enumerate() {
            if is_crown(pieces, i, tree) {
                *verdict = Verdict::Crown;
                crowns += 1;
            }
        }
    }
    // Told apart already: the user has named both.
    let told = !options.wood.is_empty();
    if !told
        && (wood.is_empty() || (options.leaves.is_empty() && has_trunk(leaves, &verdicts, tree)))
    {
        let found_wood = find_wood(found, leaves, &mut verdicts, slots, tree);
        if found_wood > 0 {
            let message = format!(
                "{found_wood} pieces of leaf primitives are taken for wood by their size, thickness and \
                 opacity; --leaves and --wood choose primitives"
            );
            reader.note(NoteCode::WoodByPiece, "", message);
        }
    }
    if crowns > 0 {
        let message = format!(
            "{crowns} closed solids were to be leaves: leaves in their colour are strewn over their surfaces \
             instead; --wood NAME keeps them whole"
        );
        reader.note(NoteCode::SolidCrowns, "", message);
    }
    verdicts
}

/// Where the tree stands and how high it is.
#[derive(Clone, Copy)]
struct Extent {
    foot: f32,
    height: f32,
}

/// Whether a piece is a solid as large as a part of the crown.
fn is_crown(pieces: &Pieces, piece: usize, tree: Extent) -> bool {
    let (low, high) = pieces.bounds(piece);
    let size = high - low;
    if diagonal((low, high)) < 0.1 * tree.height
        || size.min_element() < 0.25 * size.max_element()
        || openness(pieces, piece) > 0.4
    {
        return false;
    }
    let (shared, all) = pieces.edges(piece);
    shared * 5 >= all * 4
}

/// Whether the leaves have a piece as a trunk among them.
fn has_trunk(leaves: &[(usize, Pieces)], verdicts: &[Vec<Verdict>], tree: Extent) -> bool {
    leaves.iter().zip(verdicts).any(|((_, pieces), verdicts)| {
        let is_trunk = |i: usize| {
            let (low, high) = pieces.bounds(i);
            verdicts[i] == Verdict::Leaf
                && high.y - low.y > 0.5 * tree.height
                && low.y < tree.foot + 0.05 * tree.height
        };
        pieces.len() > 1 && (0..pieces.len()).any(is_trunk)
    })
}

/// Finds trunk and branches among the leaves; how many pieces they are.
fn find_wood(
    found: &[Found<'_>],
    leaves: &[(usize, Pieces)],
    verdicts: &mut [Vec<Verdict>],
    slots: &Slots,
    tree: Extent,
) -> usize {
    let mut sizes: Vec<f32> = leaves
        .iter()
        .flat_map(|(_, pieces)| (0..pieces.len()).map(|i| diagonal(pieces.bounds(i))))
        .collect();
    if sizes.len() < 2 {
        return 0;
    }
    let middle = sizes.len() / 2;
    let (_, &mut typical, _) = sizes.select_nth_unstable_by(middle, f32::total_cmp);
    let mut count = 0;
    let mut left = 0;
    let before = verdicts.to_vec();
    for ((number, pieces), verdicts) in leaves.iter().zip(verdicts.iter_mut()) {
        let material = slots.known(found[*number].primitive.material);
        let mask = material.and_then(Mask::of);
        for (i, verdict) in verdicts.iter_mut().enumerate().filter(|(_, v)| **v == Verdict::Leaf) {
            let bounds = pieces.bounds(i);
            let stands = bounds.0.y < tree.foot + 0.05 * tree.height
                && bounds.1.y - bounds.0.y > 0.15 * tree.height;
            let trunk = stands && diagonal(bounds) > LARGE * typical;
            // Between cards with holes, what has none and is round is a branch.
            let branch = mask.is_some_and(|mask| {
                openness(pieces, i) < 0.3 && is_opaque(&mask, &pieces.mesh, pieces.corners(i))
            });
            if trunk || branch {
                *verdict = Verdict::Wood;
                count += 1;
            } else {
                left += 1;
            }
        }
    }
    if left == 0 {
        verdicts.clone_from_slice(&before);
        return 0;
    }
    count
}

/// How much of a piece's area its sides leave over: 1 for a flat card, 0 for a closed body.
fn openness(pieces: &Pieces, piece: usize) -> f32 {
    let positions = &pieces.mesh.positions;
    let (mut sum, mut all) = (Vec3::ZERO, 0.0);
    for t in pieces.corners(piece).chunks_exact(3) {
        let [a, b, c] = [t[0], t[1], t[2]].map(|i| positions[i as usize]);
        let area = (b - a).cross(c - a);
        sum += area;
        all += area.length();
    }
    if all > 0.0 { sum.length() / all } else { 1.0 }
}

/// Whether a mask has no holes where these triangles are.
fn is_opaque(mask: &Mask<'_>, mesh: &Mesh, corners: &[u32]) -> bool {
    const AT: [[f32; 3]; 4] =
        [[0.34, 0.33, 0.33], [0.7, 0.15, 0.15], [0.15, 0.7, 0.15], [0.15, 0.15, 0.7]];
    corners.chunks_exact(3).take(256).all(|t| {
        AT.iter().all(|shares| {
            let uv: Vec2 = t
                .iter()
                .zip(shares)
                .map(|(&corner, share)| mesh.uvs[corner as usize] * *share)
                .sum();
            mask.covers(uv)
        })
    })
}

fn diagonal((low, high): (Vec3, Vec3)) -> f32 {
    (high - low).length()
}
