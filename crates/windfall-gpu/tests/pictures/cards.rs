//! Leaves that are cards, of whose pictures a part is there.

use super::*;

/// A crown of cards with holes covers as much of its middle in few pixels as in 16 times as many, whether
/// the pieces that holes leave are larger or smaller than a pixel.
#[test]
fn cards_with_holes_cover_as_much_in_few_pixels() {
    let discs: fn(u32, u32) -> bool = |x, y| (x as f32 - 15.5).hypot(y as f32 - 15.5) < 12.0;
    let blots: fn(u32, u32) -> bool = |x, y| unit(hash(x / 3, y / 3)) < 0.25;
    for (name, solid) in [("discs", discs), ("blots", blots)] {
        let mut tree = pictured(solid);
        let mut card = square();
        card.positions.iter_mut().for_each(|p| *p *= 0.06);
        tree.foliage.shapes.fill(card);
        tree.foliage.simple_shapes = simple_shapes(&tree.foliage);
        let (trees, forest) = lone(tree);
        let gpu = upload(&trees, &forest, &Falls::none());
        // Pixels of 0.7, 2 and 7 cm of leaves of about 5 cm.
        for height in [0.6f32, 1.8, 6.0] {
            // Of a picture its middle sixteenth, and that alone in as many pixels as all of it had.
            let covered_at = |high: f32, part: usize, resolution: f32| {
                let target = Vec3::new(0.0, high, 0.0);
                let mut view = plain_view(target + Vec3::Z * 150.0, target, 0.5, false);
                view.quality.resolution = resolution;
                view.show = DebugView::Coverage;
                view.detail = Simplification { leaf_pixels: 0.0, ..Simplification::NONE };
                view.set_fov(2.0 * (height * part as f32 / 8.0 / 150.0).atan());
                let rgba = paint(&gpu, &view);
                let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
                let (w, h) = (width / part, height / part);
                let first = (height - h) / 2;
                let rows = first..first + h;
                let row = |y: usize| &rgba[4 * (y * width + (width - w) / 2)..][..4 * w];
                let sum =
                    rows.clone().flat_map(row).step_by(4).map(|&byte| linear(byte)).sum::<f32>();
                sum / (w * rows.len()) as f32
            };
            // Of near leaves there are few in a picture: those at four heights.
            let covered = |part: usize, resolution: f32| {
                let at = |high: f32| covered_at(high, part, resolution);
                [6.9, 7.3, 7.7, 8.1].map(at).iter().sum::<f32>() / 4.0
            };
            let many = covered(1, 1.0);
            for (resolution, most) in [(1.0, 0.07), (0.5, 0.1)] {
                let few = covered(4, resolution);
                // Chance of four samples in each of 880 pixels is 2%, and more where cards are few pixels wide;
                // of a quarter of the pixels twice as much.
                let off = few / many - 1.0;
                assert!(
                    off.abs() < most,
                    "{name} at {resolution}, picture of {height} m: {few} for {many}"
                );
            }
        }
    }
}

/// Where samples become pixels, the edge of a picture is an edge, and little of it a halftone of covered and open pixels.
#[test]
fn edges_of_pictures_are_edges_in_fewer_pixels() {
    let mut tree = cards(1);
    // A twig of round leaves.
    let image = with_holes(256, |x, y| {
        let (x, y) = (x as f32 / 255.0, y as f32 / 255.0);
        let leaf = |i: i32| (0.15 + 0.14 * i as f32, 0.5 + 0.22 * (i % 2 * 2 - 1) as f32);
        (0..6).map(leaf).any(|(a, b)| (x - a).hypot(y - b) < 0.13) || (y - 0.5).abs() < 0.03
    });
    tree.foliage.materials[0] = of_cards(&tree.foliage.materials[0], image);
    let (trees, forest) = lone(tree);
    let gpu = upload(&trees, &forest, &Falls::none());
    // From above; the card is a third of the picture's height.
    let shot = |resolution: f32| {
        let target = Vec3::new(0.0, 4.0, 0.0);
        let mut view = plain_view(target + Vec3::new(0.0, 50.0, 0.5), target, 0.5, false);
        view.show = DebugView::Coverage;
        view.detail = Simplification { leaf_pixels: 0.0, ..Simplification::NONE };
        view.set_fov(2.0 * (18.0f32 / 50.0).atan());
        view.quality.resolution = resolution;
        paint(&gpu, &view)
    };
    let (full, half) = (shot(1.0), shot(0.5));
    let covered = |p: &[u8]| p.iter().step_by(4).map(|b| linear(*b)).sum::<f32>();
    let (whole, coarse) = (covered(&full), covered(&half));
    assert!(whole > 200.0 && (coarse / whole - 1.0).abs() < 0.1, "{coarse} for {whole}");
    // Pixels that go up, down and up again, or the other way round.
    let zigzags = |p: &[u8]| {
        let width = SIZE.0 as usize;
        let value = |i: usize| i32::from(p[4 * i]);
        let along = |step: usize| {
            let steps =
                move |i: usize| [0, 1, 2].map(|n| value(i + (n + 1) * step) - value(i + n * step));
            let starts = 0..width * SIZE.1 as usize - 3 * step;
            starts.map(steps).filter(|[a, b, c]| {
                a.abs().min(b.abs()).min(c.abs()) > 30 && a * b < 0 && b * c < 0
            })
        };
        along(1).count() + along(width).count()
    };
    // Samples by the share alone make 119.
    let (full, half) = (zigzags(&full), zigzags(&half));
    assert!(full == 0 && half < 70, "{half} zigzags, {full} in full resolution");
}

/// A level card, 1 m wide.
fn square() -> LeafShape {
    let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
    LeafShape {
        positions: corners.map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec(),
        normals: vec![Vec3::Y; 4],
        uvs: corners.map(|(x, z)| Vec2::new(x, z) + 0.5).to_vec(),
        indices: vec![0, 2, 1, 0, 3, 2],
    }
}

/// Level cards 12 m wide, one above the other, of each of which a quarter is there: squares of 5 cm.
fn cards(count: u32) -> Tree {
    let mut tree = Species::Birch.grow_with(1, count);
    tree.wood = Wood::default();
    let even = |i: u32| i.is_multiple_of(2);
    let image = with_holes(256, |x, y| even(x) && even(y));
    tree.foliage.palette = None;
    tree.foliage.materials[0] = of_cards(&tree.foliage.materials[0], image);
    tree.foliage.shapes = vec![square()];
    for (i, leaf) in tree.foliage.leaves.iter_mut().enumerate() {
        *leaf = Leaf {
            center: Vec3::Y * (4.0 + i as f32),
            orientation: Quat::IDENTITY,
            scale: 12.0,
            shape: 0,
            material: 0,
            bent_normal: Vec3::new(0.1 * i as f32, 1.0, 0.0).normalize_or(Vec3::Y),
            ..*leaf
        };
    }
    tree.foliage.simple_shapes = simple_shapes(&tree.foliage);
    tree
}

/// Six cards with holes, too small for the shadow map, take 82% of the sun where one takes 25%.
#[test]
fn cards_with_holes_shade_what_those_before_them_let_through() {
    let losses = [1, 6].map(|count| {
        let (trees, forest) = lone(cards(count));
        let gpu = upload(&trees, &forest, &Falls::none());
        let [with, without] = [true, false].map(|shadows| {
            let eye = Vec3::new(0.0, 14.0, 150.0);
            let mut view = plain_view(eye, Vec3::ZERO, std::f32::consts::FRAC_PI_2, shadows);
            (view.detail, view.shadow_detail) = (Simplification::NONE, Simplification::NONE);
            // The ground below the cards alone.
            view.set_fov(2.0 * (0.4f32 / 150.0).atan());
            paint(&gpu, &view)
        });
        let dark = |(a, b): (&u8, &u8)| f32::from(b.saturating_sub(*a));
        with.iter().zip(&without).map(dark).sum::<f32>() / with.len() as f32
    });
    // Values go with about the square root of light.
    assert!(losses[0] > 4.0 && losses[1] > 2.5 * losses[0], "{losses:?}");
}
