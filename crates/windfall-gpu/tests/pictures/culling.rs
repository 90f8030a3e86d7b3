//! Culling changes no picture.

use super::{SIZE, counts, lone, paint_on, stand, targets, upload, view};
use glam::{Mat4, Vec2, Vec3, Vec4};
use windfall_core::forest::{Instance, Placement, Terrain};
use windfall_core::simplify::FadeBy;
use windfall_core::tree::{Tree, WoodVertex};
use windfall_core::wind::Wind;
use windfall_gpu::{Culling, Falls, Projection};
use windfall_tree::prepare;
use windfall_tree::species::Species;

/// A board of wood, 60 m wide and 40 m high, that faces +Z.
fn board() -> Tree {
    let mut board = Species::Birch.grow_with(1, 0);
    let corners = [(-30.0, 0.0), (30.0, 0.0), (30.0, 40.0), (-30.0, 40.0)];
    board.wood.vertices = corners
        .iter()
        .map(|&(x, y)| WoodVertex {
            position: Vec3::new(x, y, 0.0),
            normal: Vec3::Z,
            uv: Vec2::new(x, y),
            material: 0,
        })
        .collect();
    board.wood.indices = vec![0, 1, 2, 0, 2, 3];
    prepare(&mut board);
    board
}

/// In a storm a tree reaches farther than at rest: its edge leans into view.
#[test]
fn what_leans_into_view_is_drawn() {
    let (trees, forest) = lone(board());
    let falls = Falls { wind: Wind::new(14.0, 0.0, 0.0, 3), ..Falls::none() };
    let forest = upload(&trees, &forest, &falls);
    let targets = targets();
    let mut seen = 0;
    for step in 0..24 {
        // Past its edge, ever farther to the side.
        let x = 70.0 + 0.4 * step as f32;
        let [all, sphere, clip_space] =
            [Culling::Off, Culling::Sphere, Culling::ClipSpace].map(|culling| {
                let mut view = view([x, 30.0, 50.0], [x, 30.0, 0.0]);
                view.culling = culling;
                paint_on(&targets, &forest, &view)
            });
        assert!(sphere == all && clip_space == all, "{x} m");
        seen += usize::from(counts(&forest).visible > 0);
    }
    assert!((4..20).contains(&seen), "{seen}: the board leaves the picture on the way");
}

/// Past the edge of a board that hides a wood: what the depth of the frame before hid comes into view.
#[test]
fn culling_leaves_out_only_what_is_not_seen() {
    let trees = vec![Species::Birch.grow_with(1, 800), board()];
    let placement = Placement {
        trees: 80,
        spacing: 7.0,
        keep_out: Vec::new(),
        scale: (0.8, 1.2),
        season_spread: 0.1,
        seed: 3,
    };
    let mut placed = placement.place(Terrain::flat(), &[1.0, 0.0]);
    placed.instances.push(Instance { yaw: 0.0, ..stand(Vec3::new(0.0, 0.0, 55.0), 1) });
    let forest = upload(&trees, &placed, &Falls::none());
    let targets = targets();
    // Leaves that fade by opacity are never quads.
    let steps =
        (0..5).map(|step| (FadeBy::Size, step)).chain([(FadeBy::Opacity, 1), (FadeBy::Opacity, 4)]);
    let mut drawn = [[0; 4]; 7];
    for ((by, step), drawn) in steps.zip(&mut drawn) {
        let x = 10.0 * step as f32;
        let pictures = Culling::ALL.map(|culling| {
            let mut view = view([x, 1.7, 75.0], [x, 3.0, 0.0]);
            view.culling = culling;
            view.view.detail.fade.by = by;
            let picture = paint_on(&targets, &forest, &view);
            let of_view = counts(&forest);
            drawn[culling as usize] = of_view.visible;
            if culling == Culling::Occlusion {
                assert_eq!(of_view.visible + of_view.hidden, drawn[Culling::Sphere as usize]);
            } else {
                assert_eq!(of_view.hidden, 0);
            }
            picture
        });
        for (picture, culling) in pictures.iter().zip(Culling::ALL) {
            assert!(*picture == pictures[0], "step {step}, {by:?}: {culling}");
        }
    }
    for [off, clip_space, sphere, _] in drawn {
        assert!(off >= sphere && sphere >= clip_space && clip_space > 50, "{drawn:?}");
    }
    // The first frame knows of none before it; the second is all board; the last looks past it.
    assert!(drawn[0][3] == drawn[0][2] && drawn[1][3] < 10 && drawn[4][3] > 20, "{drawn:?}");
}

/// Off-centre views, as those of an eye of a headset or of a wall of screens, before a wood half of which a board hides.
#[test]
fn culling_leaves_out_only_what_an_off_centre_view_does_not_show() {
    let trees = vec![Species::Birch.grow_with(1, 300), board()];
    let placement = Placement { trees: 120, spacing: 6.0, seed: 3, ..Placement::default() };
    let mut placed = placement.place(Terrain::flat(), &[1.0, 0.0]);
    placed.instances.push(Instance { yaw: 0.0, ..stand(Vec3::new(-30.0, 0.0, 55.0), 1) });
    let forest = upload(&trees, &placed, &Falls::none());
    let targets = targets();
    let aspect = SIZE.0 as f32 / SIZE.1 as f32;
    let centred = Mat4::perspective_infinite_reverse_rh(0.8, aspect, 0.1);
    for (x, y) in [(0.0, 0.0), (0.7, 0.0), (-0.7, 0.0), (0.5, 0.4)] {
        let mut view = view([0.0, 1.7, 90.0], [0.0, 1.7, 0.0]);
        let matrix = Mat4 { z_axis: Vec4::new(x, y, 0.0, -1.0), ..centred };
        view.camera.projection = Projection::Matrix(matrix);
        let [all, seen] = [Culling::Sphere, Culling::Occlusion].map(|culling| {
            view.culling = culling;
            paint_on(&targets, &forest, &view);
            let picture = paint_on(&targets, &forest, &view);
            (picture, counts(&forest).visible)
        });
        assert!(all.0 == seen.0, "{x} {y}: {} of {} trees", seen.1, all.1);
        // Of off-centre views nothing is found hidden; of the centred one the board's half of the wood is.
        assert_eq!(seen.1 < all.1, (x, y) == (0.0, 0.0), "{x} {y}: {} of {}", seen.1, all.1);
    }
}
