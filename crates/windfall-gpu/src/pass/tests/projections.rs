//! Projections of hosts against Windfall's pinhole.

use super::hosts::{HostPass, apart, glade, host_light, picture};
use super::{Gpu, Watched};
use crate::base::constants::DRAW_WORDS;
use crate::{Camera, Culling, DepthOnly, Light, Options, Projection, Quality, Renderer, Sky, View};
use glam::{DVec3, Mat4, Vec4};
use windfall_core::simplify::{Reduction, Simplification};

const SIZE: (u32, u32) = (160, 90);
const ASPECT: f32 = SIZE.0 as f32 / SIZE.1 as f32;

/// The pinhole's own matrix in a host's hands: the same picture, whatever is culled. Trees before the ground are
/// not hidden by it.
#[test]
fn a_hosts_matrix_shows_what_the_pinhole_shows() {
    let gpu = Gpu::get();
    let (trees, placed, falls) = glade();
    let camera = Camera::look_at(DVec3::new(0.0, 30.0, 18.0), DVec3::Y, 0.8, 0.1);
    let reversed = Mat4::perspective_infinite_reverse_rh(0.8, ASPECT, 0.1);
    // The same rays, with a far plane.
    let (near, far) = (0.2, 300.0);
    let bounded = Mat4 {
        z_axis: Vec4::new(0.0, 0.0, near / (far - near), -1.0),
        w_axis: Vec4::new(0.0, 0.0, near * far / (far - near), 0.0),
        ..reversed
    };
    let view =
        View { light: Light::Sky(Sky { haze: 0.0, ..Sky::default() }, None), ..View::new(camera) };
    let mut watched = Watched::new(gpu, DVec3::ZERO, &trees, &placed, falls);
    for culling in Culling::ALL {
        let view = View { culling, ..view.clone() };
        let (own, counts) = picture(gpu, &mut watched, &view, SIZE);
        assert!(counts.visible > 5);
        for matrix in [reversed, bounded] {
            let projection = Projection::Matrix(matrix);
            let view = View { camera: Camera { projection, ..camera }, ..view.clone() };
            let (of_host, counts) = picture(gpu, &mut watched, &view, SIZE);
            let difference = apart(&own, &of_host);
            assert!(difference < 1.0, "{culling}, {matrix}: {difference} of 255, {counts:?}");
        }
    }
}

/// An orthographic view is that of a camera very far away with a long lens: the same trees and leaves in the same
/// places, small ones as quads too, near ones in front.
#[test]
fn an_orthographic_view_is_that_of_a_very_long_lens() {
    let gpu = Gpu::get();
    let (trees, placed, falls) = glade();
    let mut watched = Watched::new(gpu, DVec3::ZERO, &trees, &placed, falls);
    let middle = DVec3::new(0.0, 4.0, 0.0);
    let way = DVec3::new(0.3, 0.4, 1.0).normalize();
    let half = 4.0f32;
    let at = |distance: f64, projection| Camera {
        projection,
        ..Camera::look_at(middle + way * distance, middle, 0.8, 0.1)
    };
    let (near, far) = (1.0, 120.0);
    let orthographic = |near, far| {
        Projection::Matrix(Mat4::orthographic_rh(
            -half * ASPECT,
            half * ASPECT,
            -half,
            half,
            near,
            far,
        ))
    };
    // What is 10 m nearer is a thousandth larger: 5 mm at the edge of the picture, of whose pixels each is 9 cm wide.
    let away = 8000.0;
    let lens = Projection::Perspective { fov_y: 2.0 * (half / away).atan(), near: 1000.0 };
    let renderer = |reversed_depth| {
        let options = Options {
            reversed_depth,
            depth_only: Some(DepthOnly {
                format: wgpu::TextureFormat::Depth32Float,
                reversed: reversed_depth,
                samples: 1,
                unclipped: false,
            }),
            ..Options::foliage(wgpu::TextureFormat::Rgba16Float, wgpu::TextureFormat::Depth32Float)
        };
        Renderer::new(&gpu.device, &options).unwrap()
    };
    let (reversed, forward) = (renderer(true), renderer(false));
    let none = Simplification::NONE;
    let few =
        Simplification { reduction: Reduction::Distance { d0: 5.0 }, ..Simplification::DEFAULT };
    let mut quads = Vec::new();
    // Each leaf in its own shape; as a quad where it is small; fewer of them.
    for detail in [none, Simplification { leaf_pixels: 100.0, ..none }, few] {
        let mut draw = |renderer: &Renderer, camera| {
            let view = View {
                detail,
                light: host_light(),
                quality: Quality { sway: false, ..Quality::PLAIN },
                ..View::new(camera)
            };
            let mut state = renderer.view(&watched.forest);
            let of = (&gpu.device, &gpu.queue);
            let forest = &mut watched.forest;
            let pass = HostPass::draw(of, renderer, (forest, &mut state), &view, SIZE);
            let buffers = state.buffers.as_ref().unwrap();
            let of_quads = buffers.quads.as_ref().map_or(0, |quads| {
                let words = gpu.words(&quads.buffers.arguments);
                let draws = words[..(DRAW_WORDS * quads.buffers.draws) as usize].chunks(5);
                draws.map(|draw| draw[0] / 6).sum::<u32>()
            });
            quads.push(of_quads);
            pass
        };
        let by_lens = draw(&reversed, at(f64::from(away), lens));
        // Depth is 1 near: the planes change places.
        let views = [
            draw(&reversed, at(40.0, orthographic(far, near))),
            draw(&forward, at(40.0, orthographic(near, far))),
        ];
        assert!((0.1..0.9).contains(&by_lens.coverage()), "{}", by_lens.coverage());
        for view in views {
            let (coverage, colors) = view.apart(&by_lens);
            let covered = by_lens.coverage();
            let most = 0.08 * covered;
            assert!(coverage < most && colors < most, "{coverage} {colors} of {covered}");
            let depth = view.depth.iter().filter(|d| **d > 0.0 && **d < 1.0).count() as f32;
            let depth = depth / view.depth.len() as f32;
            assert!((depth - view.coverage()).abs() < 0.02, "{depth} for {}", view.coverage());
        }
    }
    let [none, small, few] = [0, 3, 6].map(|i| &quads[i..i + 3]);
    assert!(none == [0; 3] && small.iter().chain(few).all(|n| *n > 3000), "{quads:?}");
}
