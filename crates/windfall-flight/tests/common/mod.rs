//! A fall that tests write as CSV, JSON and glTF, bend and break.
#![allow(dead_code, reason = "every test file uses a part of it")]

use std::fmt::Write as _;
use windfall_core::glam::{Quat, Vec3};

/// A sheet of a leaf that falls at 0.7 m/s, swinging, at 30 Hz.
pub fn key(i: usize) -> (f32, Vec3, Quat) {
    let t = i as f32 / 30.0;
    let p = Vec3::new(0.2 * (6.0 * t).sin(), -0.7 * t, 0.1 * (3.0 * t).cos());
    (t, p, Quat::from_rotation_x(0.8 * (6.0 * t).cos()))
}

pub fn csv(rows: usize) -> String {
    let mut out = String::from("time,x,y,z,qx,qy,qz,qw\n");
    for i in 0..rows {
        let (t, p, q) = key(i);
        writeln!(out, "{t},{},{},{},{},{},{},{}", p.x, p.y, p.z, q.x, q.y, q.z, q.w)
            .expect("a string takes all");
    }
    out
}

/// One channel of a test animation: path, interpolation, times, values.
#[derive(Clone)]
pub struct Channel(pub &'static str, pub &'static str, pub Vec<f32>, pub Vec<f32>);

/// One animation: its name, and its channels with the node of each.
pub struct Take(pub Option<&'static str>, pub Vec<(usize, Channel)>);

/// A `.glb` in which node i, called "leaf<i>", has the i-th list of channels.
pub fn glb(nodes: &[Vec<Channel>]) -> Vec<u8> {
    let names: Vec<String> = (0..nodes.len()).map(|i| format!(r#"{{"name":"leaf{i}"}}"#)).collect();
    let channels =
        nodes.iter().enumerate().flat_map(|(i, list)| list.iter().map(move |c| (i, c.clone())));
    let (json, bin) = gltf(&names.join(","), &[Take(None, channels.collect())], None);
    pack(json, &bin)
}

/// A `.glb` of nodes (in JSON) and animations.
pub fn takes(nodes: &str, takes: &[Take]) -> Vec<u8> {
    let (json, bin) = gltf(nodes, takes, None);
    pack(json, &bin)
}

/// Document and buffer of nodes (in JSON) and animations; `uri` is where the document says the buffer is.
pub fn gltf(nodes: &str, takes: &[Take], uri: Option<&str>) -> (String, Vec<u8>) {
    let mut bin: Vec<u8> = Vec::new();
    let (mut views, mut accessors, mut animations) = (Vec::new(), Vec::new(), Vec::new());
    for Take(name, list) in takes {
        let (mut samplers, mut channels) = (Vec::new(), Vec::new());
        for (node, Channel(path, interpolation, times, values)) in list {
            let kind = if *path == "rotation" { ("VEC4", 4) } else { ("VEC3", 3) };
            for (data, (kind, width)) in [(times, ("SCALAR", 1)), (values, kind)] {
                let bytes: Vec<u8> = data.iter().flat_map(|v| v.to_le_bytes()).collect();
                views.push(format!(
                    r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#,
                    bin.len(),
                    bytes.len()
                ));
                let range = if kind == "SCALAR" { r#","min":[0],"max":[1]"# } else { "" };
                accessors.push(format!(
                    r#"{{"bufferView":{},"componentType":5126,"count":{},"type":"{kind}"{range}}}"#,
                    views.len() - 1,
                    data.len() / width
                ));
                bin.extend(bytes);
            }
            let n = accessors.len();
            samplers.push(format!(
                r#"{{"input":{},"output":{},"interpolation":"{interpolation}"}}"#,
                n - 2,
                n - 1
            ));
            channels.push(format!(
                r#"{{"sampler":{},"target":{{"node":{node},"path":"{path}"}}}}"#,
                samplers.len() - 1
            ));
        }
        animations.push(format!(
            r#"{{{}"samplers":[{}],"channels":[{}]}}"#,
            name.map_or(String::new(), |name| format!(r#""name":"{name}","#)),
            samplers.join(","),
            channels.join(",")
        ));
    }
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}],"buffers":[{{{}"byteLength":{}}}],
        "bufferViews":[{}],"accessors":[{}],"animations":[{}]}}"#,
        uri.map_or(String::new(), |uri| format!(r#""uri":"{uri}","#)),
        bin.len(),
        views.join(","),
        accessors.join(","),
        animations.join(",")
    );
    (json, bin)
}

fn pack(mut json: String, bin: &[u8]) -> Vec<u8> {
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let mut out = b"glTF".to_vec();
    for v in [2, (28 + json.len() + bin.len()) as u32, json.len() as u32] {
        out.extend(v.to_le_bytes());
    }
    out.extend(b"JSON");
    out.extend(json.bytes());
    out.extend((bin.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(bin);
    out
}

pub fn times(n: usize) -> Vec<f32> {
    (0..n).map(|i| key(i).0).collect()
}

pub fn translation(n: usize) -> Channel {
    Channel("translation", "LINEAR", times(n), (0..n).flat_map(|i| key(i).1.to_array()).collect())
}

pub fn rotation(n: usize) -> Channel {
    Channel("rotation", "LINEAR", times(n), (0..n).flat_map(|i| key(i).2.to_array()).collect())
}

pub fn json(rows: usize) -> String {
    let samples: Vec<String> = (0..rows)
        .map(|i| {
            let (t, p, q) = key(i);
            format!(
                r#"{{"t":{t},"x":{},"y":{},"z":{},"qx":{},"qy":{},"qz":{},"qw":{}}}"#,
                p.x, p.y, p.z, q.x, q.y, q.z, q.w
            )
        })
        .collect();
    format!("{{\"samples\":[{}]}}", samples.join(","))
}
