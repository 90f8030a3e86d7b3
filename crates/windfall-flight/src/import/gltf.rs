//! The animation of a glTF node as a fall path.

use super::{ImportOptions, Motion, check_times, even_rate, locate, sample_times, unit};
use glam::{Affine3A, Mat4, Quat, Vec3, Vec4};
use gltf::accessor::{DataType, Dimensions};
use gltf::animation::util::ReadOutputs;
use gltf::animation::{Interpolation, Property};
use gltf::{Accessor, Document, Gltf, Node};
use windfall_core::{InputError, InputErrorKind};

/// Keys of one channel. A cubic spline has three values for a key: tangent in, value, tangent out.
struct Curve<T> {
    times: Vec<f64>,
    values: Vec<T>,
    interpolation: Interpolation,
}

pub(super) fn read(
    file: &str,
    bytes: &[u8],
    options: &ImportOptions,
    repairs: &mut Vec<String>,
) -> Result<Motion, InputError> {
    // The `gltf` crate subtracts the header from this without a check.
    if let Some((b"glTF", rest)) = bytes.split_first_chunk()
        && let Some(length) = rest.get(4..8)
        && length[1..] == [0; 3]
        && length[0] < 12
    {
        let cause = format!("not a valid glTF file: {} bytes are less than its header", length[0]);
        return Err(InputError::new(file, "", InputErrorKind::Malformed, cause));
    }
    let Gltf { document, blob } = Gltf::from_slice(bytes).map_err(|e| {
        InputError::new(file, "", InputErrorKind::Malformed, format!("not a valid glTF file: {e}"))
    })?;
    check_channels(file, &document)?;
    let source = Source { file, buffers: buffers(file, &document, blob)? };

    let node = choose_node(file, &document, options)?;
    let label = node.name().map_or(format!("node {}", node.index()), |n| format!("node \"{n}\""));
    let (index, animated) = (node.index(), &document);
    let of_node = |property: Property| {
        animated.animations().flat_map(|a| a.channels()).filter(move |c| {
            c.target().node().index() == index && c.target().property() == property
        })
    };
    let missing = |what: &str| {
        InputError::new(file, &label, InputErrorKind::Missing, format!("no {what} channel"))
    };
    if of_node(Property::Translation).count() > 1 {
        repairs.push(format!("{label} is in several animations: the first is taken"));
    }
    if of_node(Property::Scale).next().is_some() {
        repairs.push(format!("{label} has a scale channel: left out, leaves keep their size"));
    }
    let channel = of_node(Property::Translation).next().ok_or_else(|| missing("translation"))?;
    let translation = source.curve(&channel, &label, |outputs| match outputs {
        ReadOutputs::Translations(v) => Some(v.map(Vec3::from).collect()),
        _ => None,
    })?;
    let mut rotation = None;
    if let Some(channel) = of_node(Property::Rotation).next() {
        let mut curve = source.curve(&channel, &label, |outputs| match outputs {
            ReadOutputs::Rotations(v) => Some(v.into_f32().map(Vec4::from).collect::<Vec<_>>()),
            _ => None,
        })?;
        prepare_rotation(file, &label, &mut curve)?;
        rotation = Some(curve);
    } else {
        repairs.push(format!("{label} has no rotation channel: it keeps its own rotation"));
    }

    let ancestors = ancestors(file, &document, &node)?;
    let frame = Affine3A::from_mat4(ancestors);
    let turn = ancestors.to_scale_rotation_translation().1;
    let own = Quat::from_array(node.transform().decomposed().1);

    // Where the two channels have different keys, the common span is sampled.
    let mut times = translation.times.clone();
    if let Some(r) = &rotation
        && r.times != times
    {
        let first = times[0].max(r.times[0]);
        let last = times[times.len() - 1].min(r.times[r.times.len() - 1]);
        if last <= first {
            let cause = "translation and rotation have no time in common";
            return Err(InputError::new(file, label, InputErrorKind::Empty, cause));
        }
        times.retain(|&t| t > first && t < last);
        times.insert(0, first);
        times.push(last);
    }
    let (rate, at) = sample_times(file, &times, options.rate)?;
    if options.rate.is_none() && even_rate(&times).is_none() {
        repairs.push(format!("keys are unevenly spaced: resampled to {rate} Hz"));
    }
    let mut motion = Motion { rate: rate as f32, positions: Vec::new(), orientations: Vec::new() };
    for t in at {
        motion.positions.push(frame.transform_point3(translation.at(t, Vec3::lerp)));
        let local = rotation.as_ref().map_or(own, |r| {
            let q = r.at(t, |a, b, x| Vec4::from(Quat::from_vec4(a).slerp(Quat::from_vec4(b), x)));
            Quat::from_vec4(q.try_normalize().unwrap_or(Vec4::W))
        });
        motion.orientations.push((turn * local).normalize());
    }
    Ok(motion)
}

/// Refuses channels of unknown nodes or properties: the `gltf` crate takes them without a check, and panics.
fn check_channels(file: &str, document: &Document) -> Result<(), InputError> {
    let nodes = document.nodes().len();
    for (i, animation) in document.as_json().animations.iter().enumerate() {
        for (k, channel) in animation.channels.iter().enumerate() {
            let refuse = |kind, cause: String| {
                Err(InputError::new(file, format!("animation {i}, channel {k}"), kind, cause))
            };
            let node = channel.target.node.value();
            if node >= nodes {
                let cause = format!("names node {node}, but there are {nodes}");
                return refuse(InputErrorKind::OutOfRange, cause);
            }
            if matches!(channel.target.path, gltf::json::validation::Checked::Invalid) {
                return refuse(InputErrorKind::Malformed, "its target path is not known".into());
            }
        }
    }
    Ok(())
}

/// The node that is named, or the only one that is animated.
fn choose_node<'a>(
    file: &str,
    document: &'a Document,
    options: &ImportOptions,
) -> Result<Node<'a>, InputError> {
    let mut animated: Vec<Node> = Vec::new();
    for channel in document.animations().flat_map(|a| a.channels()) {
        let moves =
            matches!(channel.target().property(), Property::Translation | Property::Rotation);
        let node = channel.target().node();
        if moves && animated.iter().all(|n| n.index() != node.index()) {
            animated.push(node);
        }
    }
    let names =
        || animated.iter().map(|n| n.name().unwrap_or("(unnamed)")).collect::<Vec<_>>().join(", ");
    let refuse = |kind, cause: String| Err(InputError::new(file, "animations", kind, cause));
    match &options.node {
        _ if animated.is_empty() => {
            refuse(InputErrorKind::Empty, "no node is animated: there is no path in it".into())
        }
        Some(name) => match animated.iter().position(|n| n.name() == Some(name)) {
            Some(i) => Ok(animated.swap_remove(i)),
            None => refuse(
                InputErrorKind::Missing,
                format!("no animated node is called \"{name}\"; animated are: {}", names()),
            ),
        },
        None if animated.len() > 1 => refuse(
            InputErrorKind::Unsupported,
            format!("{} nodes are animated; name one with --node: {}", animated.len(), names()),
        ),
        None => Ok(animated.swap_remove(0)),
    }
}

/// The unmoving transform above a node.
fn ancestors(file: &str, document: &Document, node: &Node) -> Result<Mat4, InputError> {
    let mut frame = Mat4::IDENTITY;
    let mut child = node.index();
    // A tree has no more levels than nodes; a file may claim otherwise.
    for _ in 0..document.nodes().len() {
        let Some(parent) = document.nodes().find(|n| n.children().any(|c| c.index() == child))
        else {
            break;
        };
        let moves = document
            .animations()
            .flat_map(|a| a.channels())
            .any(|c| c.target().node().index() == parent.index());
        if moves {
            let cause = format!(
                "its parent \"{}\" is animated too; bake the motion into one node",
                parent.name().unwrap_or("(unnamed)")
            );
            let place = format!("node \"{}\"", node.name().unwrap_or("(unnamed)"));
            return Err(InputError::new(file, place, InputErrorKind::Unsupported, cause));
        }
        frame = Mat4::from_cols_array_2d(&parent.transform().matrix()) * frame;
        child = parent.index();
    }
    if frame.is_finite() && frame.determinant().abs() > 1e-12 {
        Ok(frame)
    } else {
        let cause = "the transform of a parent is not finite or flattens everything";
        Err(InputError::new(file, "nodes", InputErrorKind::OutOfRange, cause))
    }
}

/// Unit quaternions, each in the hemisphere of the one before; a cubic's tangents go along.
fn prepare_rotation(file: &str, label: &str, curve: &mut Curve<Vec4>) -> Result<(), InputError> {
    let cubic = curve.interpolation == Interpolation::CubicSpline;
    let (stride, middle) = if cubic { (3, 1) } else { (1, 0) };
    let mut previous = Vec4::ZERO;
    for (i, key) in curve.values.chunks_exact_mut(stride).enumerate() {
        let place = format!("{label}, rotation key {i}");
        let q = unit(file, place, Quat::from_vec4(key[middle]))?;
        key[middle] = q.into();
        if key[middle].dot(previous) < 0.0 {
            for v in &mut *key {
                *v = -*v;
            }
        }
        previous = key[middle];
    }
    Ok(())
}

impl<T> Curve<T>
where
    T: Copy + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    /// Value at a time; constant before the first key and after the last (glTF 2.0, appendix C).
    fn at(&self, t: f64, linear: impl Fn(T, T, f32) -> T) -> T {
        let (i, x) = locate(&self.times, t);
        let v = &self.values;
        match self.interpolation {
            Interpolation::Linear => linear(v[i], v[i + 1], x),
            Interpolation::Step => v[if x >= 1.0 { i + 1 } else { i }],
            Interpolation::CubicSpline => {
                let dt = (self.times[i + 1] - self.times[i]) as f32;
                let (x2, x3) = (x * x, x * x * x);
                v[3 * i + 1] * (2.0 * x3 - 3.0 * x2 + 1.0)
                    + v[3 * i + 2] * (dt * (x3 - 2.0 * x2 + x))
                    + v[3 * i + 4] * (3.0 * x2 - 2.0 * x3)
                    + v[3 * i + 3] * (dt * (x3 - x2))
            }
        }
    }
}

struct Source<'a> {
    file: &'a str,
    buffers: Vec<Vec<u8>>,
}

impl Source<'_> {
    fn curve<T: Finite>(
        &self,
        channel: &gltf::animation::Channel,
        label: &str,
        values: impl Fn(ReadOutputs) -> Option<Vec<T>>,
    ) -> Result<Curve<T>, InputError> {
        let sampler = channel.sampler();
        let property = match channel.target().property() {
            Property::Rotation => "rotation",
            _ => "translation",
        };
        let place = |i: usize| format!("{label}, {property} key {i}");
        let wanted = if property == "rotation" { Dimensions::Vec4 } else { Dimensions::Vec3 };
        self.check(&sampler.input(), Dimensions::Scalar)?;
        self.check(&sampler.output(), wanted)?;
        let reader = channel.reader(|b| self.buffers.get(b.index()).map(Vec::as_slice));
        let unreadable = || {
            let cause = "the keys cannot be read";
            InputError::new(self.file, label, InputErrorKind::Malformed, cause)
        };
        let times: Vec<f64> = reader.read_inputs().ok_or_else(unreadable)?.map(f64::from).collect();
        check_times(self.file, &times, place).map_err(|mut e| {
            if e.place.is_empty() {
                e.place = format!("{label}, {property}");
            }
            e
        })?;
        let values = reader.read_outputs().and_then(values).ok_or_else(unreadable)?;
        let interpolation = sampler.interpolation();
        let each = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        if values.len() != times.len() * each {
            let cause = format!("{} times but {} values", times.len(), values.len());
            let place = format!("{label}, {property}");
            return Err(InputError::new(self.file, place, InputErrorKind::Malformed, cause));
        }
        if let Some(i) = values.iter().position(|v| !v.finite()) {
            let cause = "NaN or infinite";
            return Err(InputError::new(
                self.file,
                place(i / each),
                InputErrorKind::NotFinite,
                cause,
            ));
        }
        Ok(Curve { times, values, interpolation })
    }

    /// Refuses accessors of another type, or that reach beyond their buffer: the reader would panic.
    fn check(&self, accessor: &Accessor, wanted: Dimensions) -> Result<(), InputError> {
        let place = format!("accessor {}", accessor.index());
        let refuse = |kind, cause: &str| Err(InputError::new(self.file, &place, kind, cause));
        let (dimensions, data_type) = (accessor.dimensions(), accessor.data_type());
        // Only rotations may be of integers, which are normalised, and those of up to 16 bits.
        let known = data_type == DataType::F32
            || (wanted == Dimensions::Vec4 && data_type != DataType::U32);
        if dimensions != wanted || !known {
            let cause =
                format!("is of type {dimensions:?} of {data_type:?}; {wanted:?} of F32 is needed");
            return refuse(InputErrorKind::Malformed, &cause);
        }
        if accessor.sparse().is_some() {
            return refuse(InputErrorKind::Unsupported, "sparse keys are not supported");
        }
        let Some(view) = accessor.view() else {
            return refuse(InputErrorKind::Missing, "has no buffer view");
        };
        let stride = view.stride().unwrap_or(accessor.size());
        let needed = accessor.count().checked_sub(1).and_then(|n| {
            n.checked_mul(stride)?.checked_add(accessor.size())?.checked_add(accessor.offset())
        });
        let end = view.offset().checked_add(view.length());
        let held = self.buffers.get(view.buffer().index()).map_or(0, Vec::len);
        if stride < accessor.size()
            || needed.is_none_or(|n| n > view.length())
            || end.is_none_or(|e| e > held)
        {
            return refuse(InputErrorKind::OutOfRange, "reaches beyond its buffer");
        }
        Ok(())
    }
}

/// Vectors that can be checked.
trait Finite {
    fn finite(&self) -> bool;
}

impl Finite for Vec3 {
    fn finite(&self) -> bool {
        self.is_finite()
    }
}

impl Finite for Vec4 {
    fn finite(&self) -> bool {
        self.is_finite()
    }
}

/// The bytes of all buffers: the file's own, or those written into it as `data:` URIs.
fn buffers(
    file: &str,
    document: &Document,
    blob: Option<Vec<u8>>,
) -> Result<Vec<Vec<u8>>, InputError> {
    let mut blob = blob;
    document
        .buffers()
        .map(|buffer| {
            let place = format!("buffer {}", buffer.index());
            let refuse = |kind, cause: String| Err(InputError::new(file, &place, kind, cause));
            let data = match buffer.source() {
                gltf::buffer::Source::Bin => blob.take().unwrap_or_default(),
                gltf::buffer::Source::Uri(uri) => {
                    let Some((_, data)) =
                        uri.strip_prefix("data:").and_then(|u| u.split_once(";base64,"))
                    else {
                        return refuse(
                            InputErrorKind::Missing,
                            format!(
                                "\"{uri}\" is another file; export as .glb, with buffers inside"
                            ),
                        );
                    };
                    match base64(data) {
                        Some(data) => data,
                        None => return refuse(InputErrorKind::Malformed, "not base64".into()),
                    }
                }
            };
            if data.len() < buffer.length() {
                let cause = format!("{} bytes of {}", data.len(), buffer.length());
                return refuse(InputErrorKind::Malformed, cause);
            }
            Ok(data)
        })
        .collect()
}

/// Decodes base64 (RFC 4648, section 4).
fn base64(text: &str) -> Option<Vec<u8>> {
    let digits = text.trim_end_matches('=');
    let mut out = Vec::with_capacity(digits.len() * 3 / 4);
    let (mut bits, mut count) = (0u32, 0);
    for c in digits.bytes() {
        let digit = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(digit);
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    Some(out)
}
