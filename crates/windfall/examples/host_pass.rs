//! An engine that owns everything: its HDR target without multisampling, its depth, projection, sun, ambient
//! light and shadow map. Windfall draws foliage into its passes, between boxes of its own; while it runs, a
//! leaf is thrown and a tree planted.
//!
//!     cargo run --release --example host_pass -- host_pass.png

mod headless;

use anyhow::Context;
use headless::{device, save, texture, tone_mapped};
use std::path::Path;
use windfall::forest::Terrain;
use windfall::glam::{DMat4, DVec3, Mat4, Quat, Vec3, Vec4};
use windfall::tree::Species;
use windfall::wgpu::util::DeviceExt;
use windfall::{
    Camera, Capture, DepthOnly, Falls, Forest, HostCascade, HostLight, HostShadow, Layers, Light,
    Moment, Options, Projection, Recording, Renderer, TreeModel, TreePlace, View, wgpu,
};

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const HDR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Texels along a side of the host's shadow map, and metres that it covers.
const SHADOW_MAP: (u32, f32) = (2048, 40.0);

/// Renders the host's second frame; `size` in pixels.
pub(crate) fn render(size: (u32, u32)) -> anyhow::Result<Vec<u8>> {
    let (device, queue) = device()?;
    let color = texture(&device, HDR, size, 1);
    let depth = texture(&device, DEPTH, size, 1).create_view(&Default::default());
    let shadow_map = texture(&device, DEPTH, (SHADOW_MAP.0, SHADOW_MAP.0), 1);

    // Foliage alone, for the host's kind of pass and for its shadow map.
    let renderer = Renderer::new(
        &device,
        &Options {
            color_format: HDR,
            depth_format: DEPTH,
            reversed_depth: true,
            samples: 1,
            depth_only: Some(DepthOnly {
                format: DEPTH,
                reversed: false,
                samples: 1,
                unclipped: false,
            }),
            layers: Layers::FOLIAGE,
        },
    )?;
    let maple = TreeModel::new(&device, &queue, &Species::Maple.grow_with(3, 4000))?;
    let mut forest = Forest::new(&device, DVec3::ZERO, Terrain::flat(), Falls::default())?;
    let first = forest.insert(&maple, TreePlace::at(DVec3::new(-3.0, 0.0, 0.0), 1))?;
    // A view for the picture, one for the sun.
    let (mut picture, mut sunlit) = (renderer.view(&forest), renderer.view(&forest));

    let sun = Vec3::new(0.5, 0.75, 0.45).normalize_or(Vec3::Y);
    let (light_camera, light_matrix) = light_camera(sun);
    let map_array = shadow_map.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    });
    // The host's own projection: reversed depth, a far plane, off-centre.
    let (near, far) = (0.1, 400.0);
    let projection = Mat4::from_cols(
        Vec4::new(1.6 * size.1 as f32 / size.0 as f32, 0.0, 0.0, 0.0),
        Vec4::new(0.0, 1.6, 0.0, 0.0),
        Vec4::new(0.0, 0.12, near / (far - near), -1.0),
        Vec4::new(0.0, 0.0, near * far / (far - near), 0.0),
    );
    let (eye, target) = (DVec3::new(0.0, 4.0, 19.0), DVec3::new(0.0, 4.4, 0.0));
    let camera = Camera {
        projection: Projection::Matrix(projection),
        ..Camera::look_at(eye, target, 1.0, near)
    };
    let view_matrix =
        Mat4::from_quat(camera.rotation.conjugate()) * Mat4::from_translation(-eye.as_vec3());
    let boxes =
        Boxes::new(&device, [projection * view_matrix, light_matrix.as_mat4()], sun, &map_array);
    let light = HostLight {
        shadow: Some(HostShadow {
            view: map_array.clone(),
            cascades: vec![HostCascade {
                clip_from_world: light_matrix,
                end: 80.0,
                texel: SHADOW_MAP.1 / SHADOW_MAP.0 as f32,
            }],
            reversed: false,
        }),
        ..HostLight::new(sun, Vec3::new(3.2, 3.0, 2.6), Vec3::new(0.5, 0.62, 0.8))
    };
    let view = View { light: Light::Host(light), ..View::new(camera) };
    let view_of_sun = View::new(light_camera);

    for time in [20.0, 20.5] {
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut recording = Recording::new(&queue, &mut encoder);
        renderer.advance(&mut recording, &mut forest, Moment::at(time))?;
        // What casts shadows into the host's map, then what is seen with it.
        let map_size = (SHADOW_MAP.0, SHADOW_MAP.0);
        renderer.prepare(&mut recording, &forest, &mut sunlit, &view_of_sun, map_size)?;
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                depth_stencil_attachment: Some(attachment(
                    &shadow_map.create_view(&Default::default()),
                    1.0,
                )),
                ..Default::default()
            });
            boxes.draw_depth(&mut pass);
            renderer.draw_depth(&mut pass, &forest, &sunlit)?;
        }
        let mut recording = Recording::new(&queue, &mut encoder);
        renderer.prepare(&mut recording, &forest, &mut picture, &view, size)?;
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &color.create_view(&Default::default()),
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color { r: 0.5, g: 0.7, b: 1.0, a: 1.0 }),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: Some(attachment(&depth, 0.0)),
                ..Default::default()
            });
            boxes.draw(&mut pass);
            renderer.draw(&mut pass, &forest, &picture)?;
        }
        let capture = Capture::encode(&device, &mut encoder, &color);
        queue.submit([encoder.finish()]);
        if time > 20.0 {
            return tone_mapped(&device, &capture);
        }
        // While it runs: leaves are thrown, and another tree stands there.
        for leaf in 0..400 {
            forest.throw(first, leaf * 7, 17.0 + f64::from(leaf) * 0.007)?;
        }
        forest.insert(
            &maple,
            TreePlace { yaw: 2.0, ..TreePlace::at(DVec3::new(6.5, 0.0, -4.0), 2) },
        )?;
    }
    anyhow::bail!("there is a second frame")
}

/// The sun as a camera: a host's matrix from the world, and the same for Windfall.
fn light_camera(sun: Vec3) -> (Camera, DMat4) {
    let view = Mat4::look_to_rh(Vec3::ZERO, -sun, Vec3::Y);
    let half = 0.5 * SHADOW_MAP.1;
    let projection = Mat4::orthographic_rh(-half, half, -half, half, -60.0, 60.0);
    let camera = Camera {
        eye: DVec3::ZERO,
        rotation: Quat::from_mat4(&view).conjugate(),
        projection: Projection::Matrix(projection),
    };
    (camera, (projection * view).as_dmat4())
}

fn attachment(view: &wgpu::TextureView, far: f32) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Clear(far),
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    }
}

/// The host's own things: boxes, lit by the same sun through the same shadow map.
struct Boxes {
    vertices: wgpu::Buffer,
    count: u32,
    uniforms: wgpu::BindGroup,
    map: wgpu::BindGroup,
    color: wgpu::RenderPipeline,
    depth: wgpu::RenderPipeline,
}

const SHADER: &str = "
    struct Uniforms { clip_from_world: mat4x4<f32>, map_from_world: mat4x4<f32>, sun: vec3<f32> }
    @group(0) @binding(0) var<uniform> u: Uniforms;
    @group(1) @binding(0) var map: texture_depth_2d_array;
    @group(1) @binding(1) var compare: sampler_comparison;
    struct Vertex { @location(0) at: vec3<f32>, @location(1) normal: vec3<f32>, @location(2) color: vec3<f32> }
    struct Varyings {
        @builtin(position) clip: vec4<f32>,
        @location(0) at: vec3<f32>,
        @location(1) normal: vec3<f32>,
        @location(2) color: vec3<f32>,
    }
    @vertex fn seen(in: Vertex) -> Varyings {
        return Varyings(u.clip_from_world * vec4(in.at, 1.0), in.at, in.normal, in.color);
    }
    @vertex fn caster(in: Vertex) -> @builtin(position) vec4<f32> {
        return u.map_from_world * vec4(in.at, 1.0);
    }
    @fragment fn lit(in: Varyings) -> @location(0) vec4<f32> {
        let on_map = u.map_from_world * vec4(in.at + in.normal * 0.03, 1.0);
        let uv = on_map.xy * vec2(0.5, -0.5) + 0.5;
        let sunlit = textureSampleCompareLevel(map, compare, uv, 0, on_map.z - 1e-4);
        let light = vec3(3.2, 3.0, 2.6) / 3.1416 * max(dot(in.normal, u.sun), 0.0) * sunlit
            + vec3(0.5, 0.62, 0.8) * (0.6 + 0.4 * in.normal.y);
        return vec4(in.color * light, 1.0);
    }";

impl Boxes {
    /// Matrices of the camera and the light.
    fn new(
        device: &wgpu::Device,
        [camera, light]: [Mat4; 2],
        sun: Vec3,
        map: &wgpu::TextureView,
    ) -> Self {
        // Middle, half of the size, colour: a floor, one box before the leaves and one behind them.
        let boxes = [
            (Vec3::new(0.0, -0.5, 0.0), Vec3::new(20.0, 0.5, 20.0), Vec3::new(0.35, 0.32, 0.26)),
            (Vec3::new(-1.2, 1.5, 5.5), Vec3::new(0.9, 1.5, 0.9), Vec3::new(0.55, 0.12, 0.1)),
            (Vec3::new(-4.5, 3.0, -6.0), Vec3::new(3.0, 3.0, 1.0), Vec3::new(0.12, 0.25, 0.5)),
        ];
        let vertices: Vec<[f32; 9]> = boxes.iter().flat_map(|&of| faces(of)).collect();
        let words: Vec<f32> = [camera.to_cols_array(), light.to_cols_array()]
            .concat()
            .into_iter()
            .chain(sun.extend(0.0).to_array())
            .collect();
        let buffer = |contents: &[u8], usage| {
            let label = Some("boxes");
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label, contents, usage })
        };
        let uniforms = buffer(bytemuck::cast_slice(&words), wgpu::BufferUsages::UNIFORM);
        let compare = device.create_sampler(&wgpu::SamplerDescriptor {
            compare: Some(wgpu::CompareFunction::LessEqual),
            mag_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("boxes"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let binding = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty,
            count: None,
        };
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let depths = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Depth,
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison);
        let of_uniforms = layout("uniforms", &[binding(0, uniform)]);
        let of_map = layout("map", &[binding(0, depths), binding(1, sampler)]);
        let groups = [Some(&of_uniforms), Some(&of_map)];
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("boxes"),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let depth_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("depth of boxes"),
            bind_group_layouts: &groups[..1],
            immediate_size: 0,
        });
        let pipeline = |entry: &str, fragment: Option<&str>, compare| {
            let target = [Some(wgpu::TextureFormat::Rgba16Float.into())];
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(entry),
                layout: Some(if fragment.is_some() { &pipeline_layout } else { &depth_layout }),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(entry),
                    compilation_options: Default::default(),
                    buffers: &[wgpu::VertexBufferLayout {
                        array_stride: 36,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes: &wgpu::vertex_attr_array![
                            0 => Float32x3, 1 => Float32x3, 2 => Float32x3
                        ],
                    }],
                },
                primitive: wgpu::PrimitiveState {
                    cull_mode: Some(wgpu::Face::Back),
                    ..Default::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(compare),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: fragment.map(|entry| wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(entry),
                    compilation_options: Default::default(),
                    targets: &target,
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let color = pipeline("seen", Some("lit"), wgpu::CompareFunction::GreaterEqual);
        let group = |layout, entries: &[wgpu::BindGroupEntry<'_>]| {
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries })
        };
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        Self {
            vertices: buffer(bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
            count: vertices.len() as u32,
            uniforms: group(&of_uniforms, &[entry(0, uniforms.as_entire_binding())]),
            map: group(
                &of_map,
                &[
                    entry(0, wgpu::BindingResource::TextureView(map)),
                    entry(1, wgpu::BindingResource::Sampler(&compare)),
                ],
            ),
            depth: pipeline("caster", None, wgpu::CompareFunction::LessEqual),
            color,
        }
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.color);
        pass.set_bind_group(0, &self.uniforms, &[]);
        pass.set_bind_group(1, &self.map, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.draw(0..self.count, 0..1);
    }

    fn draw_depth(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.depth);
        pass.set_bind_group(0, &self.uniforms, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.draw(0..self.count, 0..1);
    }
}

/// The six sides of a box: place, normal, colour.
fn faces((middle, half, color): (Vec3, Vec3, Vec3)) -> Vec<[f32; 9]> {
    let mut vertices = Vec::new();
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for side in [-1.0, 1.0] {
            let normal = axis * side;
            let along = Vec3::new(axis.y, axis.z, axis.x);
            let across = normal.cross(along);
            for (a, b) in [(-1, -1), (1, -1), (1, 1), (-1, -1), (1, 1), (-1, 1)] {
                let corner = normal + along * a as f32 + across * b as f32;
                let at = middle + corner * half;
                let all = [at.to_array(), normal.to_array(), color.to_array()].concat();
                vertices.push(all.try_into().unwrap_or([0.0; 9]));
            }
        }
    }
    vertices
}

fn main() -> anyhow::Result<()> {
    let path = std::env::args_os().nth(1).unwrap_or("host_pass.png".into());
    let size = (960, 540);
    save(Path::new(&path), &render(size)?, size).context("host_pass.png")
}
