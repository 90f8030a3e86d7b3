//! The animation of a glTF node as a fall path.

mod take;

use super::{
    ImportOptions, Motion, NoteCode, Notes, Resolve, check_times, even_rate, locate, sample_times,
    too_few, unit,
};
use glam::{Affine3A, Mat4, Quat, Vec3, Vec4};
use gltf::accessor::{DataType, Dimensions};
use gltf::animation::util::ReadOutputs;
use gltf::animation::{Interpolation, Property};
use gltf::{Accessor, Document, Gltf, Node};
use take::{Take, label};
use windfall_core::path::MIN_SAMPLES;
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
    resolve: Option<&mut Resolve<'_>>,
    notes: &mut Notes<'_>,
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
    let take = Take::choose(file, &document, options, notes)?;
    let source = Source { file, buffers: buffers(file, &document, blob, resolve)? };
    let place = label(&take.node);
    if take.channel(take.node.index(), Property::Scale).is_some() {
        let message = "has a scale channel: left out, leaves keep their size";
        notes.add(NoteCode::ScaleLeftOut, &place, message);
    }
    let leaf = source.joint(&take, &take.node)?;
    let parents = take
        .moving_parents()
        .map(|parent| {
            let scale = take.channel(parent.index(), Property::Scale);
            let scale = scale.map(|c| source.vectors(&c, &label(parent))).transpose()?;
            Ok((parent.index(), source.joint(&take, parent)?, scale))
        })
        .collect::<Result<Vec<_>, InputError>>()?;

    let joints = || std::iter::once(&leaf).chain(parents.iter().map(|(_, joint, _)| joint));
    let Some(span) = span(joints().filter_map(|j| j.translation.as_ref())) else {
        return Err(take.no_translation(file));
    };
    if joints().all(|j| j.rotation.is_none()) {
        let message = "has no rotation channel: it keeps its own rotation";
        notes.add(NoteCode::NoRotation, &place, message);
    }
    if !parents.is_empty() {
        let names: Vec<String> = take.moving_parents().map(label).collect();
        let message = format!(
            "the motion of its animated parents is combined with its own: {}",
            names.join(", ")
        );
        notes.add(NoteCode::ParentMotion, &place, message);
    }
    for joint in joints() {
        if let Some(rotation) = &joint.rotation {
            note_rotation(&joint.label, rotation, span, notes)?;
        }
    }

    // The channel with the most keys is sampled where it has them, evenly spaced ones first.
    let curves: Vec<Vec<f64>> = joints()
        .flat_map(|j| {
            [j.translation.as_ref().map(|c| &c.times), j.rotation.as_ref().map(|c| &c.times)]
        })
        .flatten()
        .map(|times| within(times, span))
        .collect();
    let times = curves
        .iter()
        .filter(|times| times.len() >= MIN_SAMPLES)
        .rev()
        .max_by_key(|times| (even_rate(times).is_some(), times.len()));
    let most = curves.iter().map(Vec::len).max().unwrap_or(0);
    let Some(times) = times.filter(|_| span.0 < span.1) else {
        let moved = joints().find(|j| j.translation.is_some()).unwrap_or(&leaf);
        let keys = if span.0 < span.1 { most } else { 1 };
        return Err(too_few(file, &format!("{}, translation", moved.label), keys));
    };
    let (rate, at) = sample_times(file, times, options.rate)?;
    if options.rate.is_none() && even_rate(times).is_none() {
        let message = format!("keys are unevenly spaced: resampled to {rate} Hz");
        notes.add(NoteCode::Resampled, "", message);
    }
    let frames = Frames::new(&take, &parents);
    let mut motion = Motion { rate: rate as f32, positions: Vec::new(), orientations: Vec::new() };
    for t in at {
        let frame = frames.at(t).ok_or_else(|| {
            let cause = "the transform of a parent is not finite or flattens everything";
            InputError::new(file, "nodes", InputErrorKind::OutOfRange, cause)
        })?;
        motion.positions.push(frame.affine.transform_point3(leaf.translation_at(t)));
        motion.orientations.push((frame.turn * leaf.rotation_at(t)).normalize());
    }
    Ok(motion)
}

/// First and last time of curves; none if there are none.
fn span<'a>(curves: impl Iterator<Item = &'a Curve<Vec3>>) -> Option<(f64, f64)> {
    curves
        .map(|c| (c.times[0], c.times[c.times.len() - 1]))
        .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// The times within a span, with its ends.
fn within(times: &[f64], (first, last): (f64, f64)) -> Vec<f64> {
    let inner = times.iter().copied().filter(|&t| t > first && t < last);
    std::iter::once(first).chain(inner).chain([last]).collect()
}

/// Notes fast turns, and rotations that cover a part of the span only; refuses those that cover none.
fn note_rotation(
    label: &str,
    curve: &Curve<Vec4>,
    span: (f64, f64),
    notes: &mut Notes<'_>,
) -> Result<(), InputError> {
    let (first, last) = (curve.times[0], curve.times[curve.times.len() - 1]);
    if curve.times.len() > 1 && (first >= span.1 || last <= span.0) {
        let cause = "translation and rotation have no time in common";
        return Err(InputError::new(notes.file, label, InputErrorKind::Empty, cause));
    }
    let tolerance = 1e-3 * (span.1 - span.0);
    if curve.times.len() > 1 && (first > span.0 + tolerance || last < span.1 - tolerance) {
        let message = format!(
            "has rotation keys from {first:.3} s to {last:.3} s only: the first and last are held from {:.3} s to \
             {:.3} s",
            span.0, span.1
        );
        notes.add(NoteCode::RotationHeld, label, message);
    }
    // A step is meant to jump.
    if curve.interpolation != Interpolation::Step {
        notes.fast_turns(
            label,
            curve.times.iter().zip(curve.keys()).map(|(&t, &q)| (t, Quat::from_vec4(q))),
        );
    }
    Ok(())
}

/// Motion of one node within its parent.
struct Joint {
    label: String,
    /// What the node has where no channel says otherwise.
    rest: (Vec3, Quat, Vec3),
    translation: Option<Curve<Vec3>>,
    rotation: Option<Curve<Vec4>>,
}

impl Joint {
    fn translation_at(&self, t: f64) -> Vec3 {
        self.translation.as_ref().map_or(self.rest.0, |c| c.at(t, Vec3::lerp))
    }

    fn rotation_at(&self, t: f64) -> Quat {
        self.rotation.as_ref().map_or(self.rest.1, |r| {
            let q = r.at(t, |a, b, x| Vec4::from(Quat::from_vec4(a).slerp(Quat::from_vec4(b), x)));
            Quat::from_vec4(q.try_normalize().unwrap_or(Vec4::W))
        })
    }
}

/// A moving parent: its node, its motion and its scale.
type Parent = (usize, Joint, Option<Curve<Vec3>>);

/// Where the parents put the leaf at a time.
#[derive(Clone, Copy)]
struct Frame {
    affine: Affine3A,
    turn: Quat,
}

/// The transforms above the leaf, from the root down.
struct Frames<'a> {
    /// Transforms that do not move, each before the moving parent at its side.
    moving: Vec<(Mat4, &'a Parent)>,
    /// Those below the last moving parent.
    below: Mat4,
}

impl<'a> Frames<'a> {
    fn new(take: &Take, parents: &'a [Parent]) -> Self {
        let (mut moving, mut below) = (Vec::new(), Mat4::IDENTITY);
        for node in take.parents.iter().rev() {
            if let Some(parent) = parents.iter().find(|p| p.0 == node.index()) {
                moving.push((below, parent));
                below = Mat4::IDENTITY;
            } else {
                below *= Mat4::from_cols_array_2d(&node.transform().matrix());
            }
        }
        Self { moving, below }
    }

    /// The frame at a time; none if it is not finite or flattens everything.
    fn at(&self, t: f64) -> Option<Frame> {
        let mut world = Mat4::IDENTITY;
        for (above, (_, joint, scale)) in &self.moving {
            let scale = scale.as_ref().map_or(joint.rest.2, |c| c.at(t, Vec3::lerp));
            let (rotation, translation) = (joint.rotation_at(t), joint.translation_at(t));
            world = world
                * *above
                * Mat4::from_scale_rotation_translation(scale, rotation, translation);
        }
        Frame::new(world * self.below)
    }
}

impl Frame {
    fn new(world_from_parent: Mat4) -> Option<Self> {
        (world_from_parent.is_finite() && world_from_parent.determinant().abs() > 1e-12).then(
            || Self {
                affine: Affine3A::from_mat4(world_from_parent),
                turn: world_from_parent.to_scale_rotation_translation().1,
            },
        )
    }
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
    /// The values at the keys, without tangents.
    fn keys(&self) -> impl Iterator<Item = &T> {
        let cubic = self.interpolation == Interpolation::CubicSpline;
        let (first, stride) = if cubic { (1, 3) } else { (0, 1) };
        self.values.iter().skip(first).step_by(stride)
    }

    /// Value at a time; constant before the first key and after the last (glTF 2.0, appendix C).
    fn at(&self, t: f64, linear: impl Fn(T, T, f32) -> T) -> T {
        let v = &self.values;
        if self.times.len() == 1 {
            return v[v.len() / 2];
        }
        let (i, x) = locate(&self.times, t);
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
    /// The channels of a node in a take.
    fn joint(&self, take: &Take, node: &Node) -> Result<Joint, InputError> {
        let label = label(node);
        let translation = take
            .channel(node.index(), Property::Translation)
            .map(|channel| self.vectors(&channel, &label))
            .transpose()?;
        let rotation = take
            .channel(node.index(), Property::Rotation)
            .map(|channel| {
                let mut curve = self.curve(&channel, &label, |outputs| match outputs {
                    ReadOutputs::Rotations(v) => {
                        Some(v.into_f32().map(Vec4::from).collect::<Vec<_>>())
                    }
                    _ => None,
                })?;
                prepare_rotation(self.file, &label, &mut curve)?;
                Ok(curve)
            })
            .transpose()?;
        let (t, r, s) = node.transform().decomposed();
        let rest = (Vec3::from(t), Quat::from_array(r), Vec3::from(s));
        Ok(Joint { label, rest, translation, rotation })
    }

    /// A channel of translations or scales.
    fn vectors(
        &self,
        channel: &gltf::animation::Channel,
        label: &str,
    ) -> Result<Curve<Vec3>, InputError> {
        self.curve(channel, label, |outputs| match outputs {
            ReadOutputs::Translations(v) | ReadOutputs::Scales(v) => {
                Some(v.map(Vec3::from).collect())
            }
            _ => None,
        })
    }

    fn curve<T: Finite>(
        &self,
        channel: &gltf::animation::Channel,
        label: &str,
        values: impl Fn(ReadOutputs) -> Option<Vec<T>>,
    ) -> Result<Curve<T>, InputError> {
        let sampler = channel.sampler();
        let property = match channel.target().property() {
            Property::Rotation => "rotation",
            Property::Scale => "scale",
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
        check_times(self.file, &times, place)?;
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

/// The bytes of all buffers: the file's own, those written into it as `data:` URIs, or those of files beside.
fn buffers(
    file: &str,
    document: &Document,
    blob: Option<Vec<u8>>,
    mut resolve: Option<&mut Resolve<'_>>,
) -> Result<Vec<Vec<u8>>, InputError> {
    let mut blob = blob;
    document
        .buffers()
        .map(|buffer| {
            let place = format!("buffer {}", buffer.index());
            let refuse = |kind, cause: String| InputError::new(file, &place, kind, cause);
            let data = match buffer.source() {
                gltf::buffer::Source::Bin => blob.take().unwrap_or_default(),
                gltf::buffer::Source::Uri(uri) => {
                    if let Some((_, data)) =
                        uri.strip_prefix("data:").and_then(|u| u.split_once(";base64,"))
                    {
                        base64(data)
                            .ok_or_else(|| refuse(InputErrorKind::Malformed, "not base64".into()))?
                    } else {
                        beside(uri, resolve.as_deref_mut())
                            .map_err(|(kind, cause)| refuse(kind, cause))?
                    }
                }
            };
            if data.len() < buffer.length() {
                let cause = format!("{} bytes of {}", data.len(), buffer.length());
                return Err(refuse(InputErrorKind::Malformed, cause));
            }
            Ok(data)
        })
        .collect()
}

/// The bytes of a file beside this one.
fn beside(
    uri: &str,
    resolve: Option<&mut Resolve<'_>>,
) -> Result<Vec<u8>, (InputErrorKind, String)> {
    let Some(resolve) = resolve else {
        let cause = format!("\"{uri}\" is another file; export as .glb, with buffers inside");
        return Err((InputErrorKind::Missing, cause));
    };
    if uri.split(['/', '?', '#']).next().is_some_and(|head| head.contains(':')) {
        let cause = format!("\"{uri}\" is not a relative path; nothing is fetched elsewhere");
        return Err((InputErrorKind::Unsupported, cause));
    }
    let Some(path) = percent_decoded(uri) else {
        let cause = format!("\"{uri}\" is not a URI: its percent signs are no UTF-8");
        return Err((InputErrorKind::Malformed, cause));
    };
    resolve(&path).map_err(|cause| (InputErrorKind::Missing, format!("\"{path}\": {cause}")))
}

fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        if byte == b'%' {
            let (high, low) = (rest.next()?, rest.next()?);
            let digit = |b: u8| (b as char).to_digit(16);
            bytes.push((digit(high)? * 16 + digit(low)?) as u8);
        } else {
            bytes.push(byte);
        }
    }
    String::from_utf8(bytes).ok()
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
