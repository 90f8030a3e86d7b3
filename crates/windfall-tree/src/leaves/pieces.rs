//! Leaf elements: the pieces of a mesh that hang together through shared edges.
//!
//! What hangs together by *index* is too small: exporters split vertices along a folded midrib,
//! where two normals meet. What hangs together by *position* is too large: leaves of one twig meet
//! at its tip. An edge in common, after welding positions, is what the two halves of a leaf have
//! and two leaves have not. Where a file tells of each vertex which leaf it is of, that is what counts.

use super::mesh::Mesh;
use glam::Vec3;
use std::collections::{HashMap, HashSet};

/// Vertices closer than this part of the mesh's median edge are one.
const WELD: f32 = 1e-4;

/// A mesh cut into pieces, in the order of their first triangles.
#[derive(Default)]
pub(crate) struct Pieces {
    pub mesh: Mesh,
    /// The place of each vertex: the same for vertices at (nearly) the same position.
    places: Vec<u32>,
    /// Corners of all pieces, one after another, and where each piece ends.
    corners: Vec<u32>,
    ends: Vec<usize>,
}

/// One piece: its own mesh, and the place of each of its vertices, numbered by their first use.
#[derive(Debug, Clone, Default)]
pub(crate) struct Piece {
    pub mesh: Mesh,
    pub places: Vec<u32>,
}

impl Pieces {
    /// Splits a mesh into its pieces.
    ///
    /// A triangle that is there twice (a back face over the same vertices) is kept once: leaves are
    /// drawn from both sides.
    pub fn cut(mesh: Mesh) -> Self {
        let places = weld(&mesh);
        let triangles = unlike(&mesh, &places);
        let mut sets = Sets::new(triangles.len());
        if mesh.leaves.is_empty() {
            join_by_edges(&mut sets, &triangles, &places);
        } else {
            let mut first: HashMap<[u32; 4], u32> = HashMap::new();
            for (i, triangle) in (0..).zip(&triangles) {
                let leaf = mesh.leaves[triangle[0] as usize].to_array().map(f32::to_bits);
                sets.join(*first.entry(leaf).or_insert(i), i);
            }
        }
        let mut piece_of_root: HashMap<u32, usize> = HashMap::new();
        let mut lists: Vec<Vec<u32>> = Vec::new();
        for (i, triangle) in triangles.iter().enumerate() {
            let next = lists.len();
            let piece = *piece_of_root.entry(sets.root(i as u32)).or_insert(next);
            if piece == next {
                lists.push(Vec::new());
            }
            lists[piece].extend(triangle);
        }
        let mut pieces = Self { mesh, places, ..Self::default() };
        for list in lists {
            pieces.corners.extend(list);
            pieces.ends.push(pieces.corners.len());
        }
        pieces
    }

    /// All of a mesh as one piece.
    pub fn whole(mesh: Mesh) -> Self {
        let places = weld(&mesh);
        let corners: Vec<u32> = unlike(&mesh, &places).into_iter().flatten().collect();
        let ends = if corners.is_empty() { Vec::new() } else { vec![corners.len()] };
        Self { mesh, places, corners, ends }
    }

    /// Adds the pieces of another mesh.
    pub fn append(&mut self, other: Self) {
        let vertices = self.mesh.positions.len() as u32;
        let (places, corners) = (self.places.iter().max().map_or(0, |p| p + 1), self.corners.len());
        self.places.extend(other.places.iter().map(|place| places + place));
        self.corners.extend(other.corners.iter().map(|corner| vertices + corner));
        self.ends.extend(other.ends.iter().map(|end| corners + end));
        self.mesh.append(other.mesh);
    }

    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// The corners of a piece.
    pub fn corners(&self, piece: usize) -> &[u32] {
        let start = if piece == 0 { 0 } else { self.ends[piece - 1] };
        &self.corners[start..self.ends[piece]]
    }

    /// Smallest box around a piece.
    pub fn bounds(&self, piece: usize) -> (Vec3, Vec3) {
        self.corners(piece)
            .iter()
            .map(|&corner| self.mesh.positions[corner as usize])
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)))
    }

    /// How many edges of a piece have two triangles, and how many there are.
    pub fn edges(&self, piece: usize) -> (usize, usize) {
        let mut counts: HashMap<(u32, u32), usize> = HashMap::new();
        for t in self.corners(piece).chunks_exact(3) {
            let [a, b, c] = [t[0], t[1], t[2]].map(|corner| self.places[corner as usize]);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *counts.entry((from.min(to), from.max(to))).or_default() += 1;
            }
        }
        (counts.values().filter(|&&count| count == 2).count(), counts.len())
    }

    /// A piece as a mesh of its own. `scratch` comes from [`Self::scratch`].
    pub fn piece(&self, piece: usize, scratch: &mut Scratch) -> Piece {
        let corners = self.corners(piece);
        let mesh = self.mesh.part(corners, &mut scratch.0);
        let mut new_place: HashMap<u32, u32> = HashMap::new();
        let mut places = vec![0; mesh.positions.len()];
        for (&corner, &index) in corners.iter().zip(&mesh.indices) {
            let next = new_place.len() as u32;
            places[index as usize] = *new_place.entry(self.places[corner as usize]).or_insert(next);
        }
        Piece { mesh, places }
    }

    /// Space for [`Self::piece`] to work in.
    pub fn scratch(&self) -> Scratch {
        Scratch(vec![u32::MAX; self.mesh.positions.len()])
    }
}

/// Space to work in.
pub(crate) struct Scratch(Vec<u32>);

/// The triangles of a mesh, each once.
fn unlike(mesh: &Mesh, places: &[u32]) -> Vec<[u32; 3]> {
    let mut seen = HashSet::new();
    mesh.indices
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]])
        .filter(|t| {
            let mut key = t.map(|corner| places[corner as usize]);
            key.sort_unstable();
            seen.insert(key)
        })
        .collect()
}

/// Joins triangles that have an edge in common; `ids` are the places of vertices.
fn join_by_edges(sets: &mut Sets, triangles: &[[u32; 3]], ids: &[u32]) {
    let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(triangles.len() * 3);
    for (i, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|corner| ids[corner as usize]);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if from != to {
                edges.push((from.min(to), from.max(to), i as u32));
            }
        }
    }
    edges.sort_unstable();
    for pair in edges.windows(2) {
        if (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1) {
            sets.join(pair[0].2, pair[1].2);
        }
    }
}

/// For each vertex the number of its place: the same for vertices at (nearly) the same position.
fn weld(mesh: &Mesh) -> Vec<u32> {
    let mut lengths: Vec<f32> = mesh
        .indices
        .chunks_exact(3)
        .map(|t| mesh.positions[t[0] as usize].distance(mesh.positions[t[1] as usize]))
        .collect();
    if lengths.is_empty() {
        return vec![0; mesh.positions.len()];
    }
    let middle = lengths.len() / 2;
    let (_, &mut median, _) = lengths.select_nth_unstable_by(middle, f32::total_cmp);
    let reach = f64::from((median * WELD).max(f32::MIN_POSITIVE));

    // Cells of twice the reach: what is near a point lies in its own cell or in the seven towards
    // which the point leans. A cell holds a few places at most, as places keep the reach apart.
    let mut cells: HashMap<[i64; 3], Vec<(Vec3, u32)>> = HashMap::new();
    let mut places = 0;
    let mut place = |position: Vec3| {
        let grid = position.as_dvec3() / (2.0 * reach);
        let home = grid.floor();
        let lean = (grid - home).to_array().map(|part| if part < 0.5 { -1 } else { 1 });
        let home = home.to_array().map(|x| x as i64);
        for neighbor in 0..8 {
            let cell = std::array::from_fn(|axis| {
                home[axis].saturating_add(if neighbor >> axis & 1 == 1 { lean[axis] } else { 0 })
            });
            let near = cells.get(&cell).and_then(|held| {
                held.iter().find(|(p, _)| f64::from(p.distance(position)) <= reach)
            });
            if let Some(&(_, id)) = near {
                return id;
            }
        }
        let id = places;
        places += 1;
        cells.entry(home).or_default().push((position, id));
        id
    };
    mesh.positions.iter().map(|&position| place(position)).collect()
}

/// Disjoint sets of triangles.
struct Sets(Vec<u32>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            // Halving the path keeps it short, without recursion.
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec4};

    fn pieces(mesh: &Mesh) -> Vec<Mesh> {
        let pieces = Pieces::cut(mesh.clone());
        let mut scratch = pieces.scratch();
        (0..pieces.len()).map(|i| pieces.piece(i, &mut scratch).mesh).collect()
    }

    fn mesh(positions: &[[f32; 3]], indices: &[u32]) -> Mesh {
        Mesh {
            positions: positions.iter().map(|&p| p.into()).collect(),
            normals: vec![Vec3::Z; positions.len()],
            uvs: vec![Vec2::ZERO; positions.len()],
            indices: indices.to_vec(),
            ..Mesh::default()
        }
    }

    #[test]
    fn halves_with_a_split_midrib_are_one_leaf() {
        //    2 5
        //   /| |\      1 and 4, 2 and 5 are at the same positions
        //  0 | | 3
        //   \| |/
        //    1 4
        let split = mesh(
            &[
                [-1., 0., 0.],
                [0., -1., 0.],
                [0., 1., 0.],
                [1., 0., 0.],
                [0., -1., 0.],
                [0., 1., 0.],
            ],
            &[0, 1, 2, 3, 5, 4],
        );
        let found = pieces(&split);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].positions.len(), 6, "split vertices stay split");
    }

    #[test]
    fn rounding_does_not_part_the_halves() {
        let split = mesh(
            &[
                [-1., 0., 0.],
                [0., -1., 0.],
                [0., 1., 0.],
                [1., 0., 0.],
                [2e-5, -1., -3e-5],
                [-4e-5, 1., 0.],
            ],
            &[0, 1, 2, 3, 5, 4],
        );
        assert_eq!(pieces(&split).len(), 1);
    }

    #[test]
    fn leaves_that_touch_at_a_point_stay_apart() {
        //  1   3
        //  |\ /|
        //  | 0 |     0 is shared, even by index
        //  |/ \|
        //  2   4
        let touching = mesh(
            &[[0., 0., 0.], [-1., 1., 0.], [-1., -1., 0.], [1., 1., 0.], [1., -1., 0.]],
            &[0, 1, 2, 0, 4, 3],
        );
        assert_eq!(pieces(&touching).len(), 2);
    }

    #[test]
    fn leaves_that_the_file_tells_apart_are_those() {
        // As in the test before, and a third triangle that has an edge with the first.
        let mut told = mesh(
            &[[0., 0., 0.], [-1., 1., 0.], [-1., -1., 0.], [1., 1., 0.], [1., -1., 0.]],
            &[0, 1, 2, 0, 4, 3, 2, 1, 4],
        );
        told.leaves = [1.0, 1.0, 2.0, 1.0, 1.0].map(Vec4::splat).to_vec();
        let found = pieces(&told);
        let corners: Vec<usize> = found.iter().map(|piece| piece.indices.len()).collect();
        assert_eq!((corners.as_slice(), found[1].positions[0]), (&[6, 3][..], told.positions[2]));
    }

    #[test]
    fn a_back_face_over_the_same_vertices_is_dropped() {
        let both = mesh(&[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], &[0, 1, 2, 0, 2, 1]);
        let found = pieces(&both);
        assert_eq!((found.len(), found[0].indices.len()), (1, 3));
    }

    #[test]
    fn equal_pieces_get_equal_indices() {
        let two = mesh(
            &[[5., 0., 0.], [0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [5., 1., 0.], [6., 0., 0.]],
            &[1, 2, 3, 0, 5, 4],
        );
        let found = pieces(&two);
        assert_eq!(found[0].indices, found[1].indices);
        assert_eq!(found[1].positions[0], Vec3::new(5.0, 0.0, 0.0));
    }
}
