//! USD's text, read back by a reader of its own. `scripts/check-export` has OpenUSD read it.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{MOMENTS, Place, angle, reference, select};
use std::collections::{BTreeMap, BTreeSet};
use windfall_core::glam::{Quat, Vec3};
use windfall_export::{Filter, LeafId, usd};

/// The lines of each instancer by their names: `positions`, and of time samples `positions 120`.
fn instancers(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut found: Vec<BTreeMap<String, String>> = Vec::new();
    let mut sampled = String::new();
    for line in text.lines().map(str::trim) {
        if line.starts_with("def PointInstancer") {
            found.push(BTreeMap::new());
        }
        let (Some(now), Some((name, value))) = (found.last_mut(), line.split_once(" = ")) else {
            if let (Some(now), Some((frame, value))) = (found.last_mut(), line.split_once(": ")) {
                now.insert(format!("{sampled} {frame}"), value.trim_end_matches(',').to_owned());
            }
            continue;
        };
        let name = name.rsplit(' ').next().unwrap();
        match name.strip_suffix(".timeSamples") {
            Some(name) => name.clone_into(&mut sampled),
            None => _ = now.insert(name.to_owned(), value.to_owned()),
        }
    }
    found
}

/// The numbers of an array of `n` numbers each.
fn numbers(text: &str, n: usize) -> Vec<Vec<f64>> {
    let words = text.split(|c: char| "[]() ,".contains(c)).filter(|word| !word.is_empty());
    let all: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
    all.chunks(n).map(<[f64]>::to_vec).collect()
}

#[test]
fn instances_are_where_the_reference_has_them_at_three_times() {
    let place = Place::new();
    let source = place.source();
    let filter = Filter { parts: "falling,landed,hanging".parse().unwrap(), ..Filter::NONE };
    let selection = select(&source, MOMENTS, filter);
    let mut bytes = Vec::new();
    let mut last = 0.0;
    usd::write_usda(&selection, "./t", &mut bytes, &mut |share| last = share).unwrap();
    assert_eq!(last, 1.0);
    let text = String::from_utf8(bytes).unwrap();
    let instancers = instancers(&text);
    for frame in [MOMENTS.first, MOMENTS.first + 31, MOMENTS.first + MOMENTS.count - 1] {
        let expected = reference(&source, MOMENTS.time(frame));
        let mut seen = BTreeSet::new();
        for lines in &instancers {
            let at =
                |name: &str| lines.get(&format!("{name} {frame}")).or(lines.get(name)).unwrap();
            let ids: Vec<u64> = numbers(at("ids"), 1).iter().map(|n| n[0] as u64).collect();
            let positions = numbers(at("positions"), 3);
            let orientations = numbers(at("orientations"), 4);
            let scales = numbers(at("scales"), 3);
            assert_eq!([positions.len(), orientations.len(), scales.len()], [ids.len(); 3]);
            for (i, id) in ids.iter().enumerate() {
                let leaf = &expected[&LeafId(*id)];
                let [x, y, z] = [0, 1, 2].map(|k| positions[i][k] as f32);
                let off = Vec3::new(x, y, z).distance(leaf.position);
                assert!(off < 1e-3, "{id}: {off} m");
                let [w, x, y, z] = [0, 1, 2, 3].map(|k| orientations[i][k] as f32);
                let off = angle(Quat::from_xyzw(x, y, z, w), leaf.orientation);
                assert!(off < 0.1, "{id}: {off} degrees");
                assert!((scales[i][0] as f32 - leaf.scale).abs() < 1e-4);
                assert!(seen.insert(*id), "{id} is there twice");
            }
        }
        assert_eq!(seen.len(), 1200);
    }
}

#[test]
fn leaves_that_do_not_fall_yet_or_any_more_are_invisible() {
    let place = Place::new();
    let source = place.source();
    let filter = Filter { parts: "falling".parse().unwrap(), ..Filter::NONE };
    let selection = select(&source, MOMENTS, filter);
    let mut bytes = Vec::new();
    usd::write_usda(&selection, "./t", &mut bytes, &mut |_| ()).unwrap();
    let instancers = instancers(&String::from_utf8(bytes).unwrap());
    for frame in MOMENTS.frames() {
        let falls = reference(&source, MOMENTS.time(frame));
        let falls: BTreeSet<u64> =
            falls.iter().filter(|(_, w)| w.phase == "falling").map(|(id, _)| id.0).collect();
        let mut shown = BTreeSet::new();
        for lines in &instancers {
            let set = |text: &str| -> BTreeSet<u64> {
                numbers(text, 1).iter().map(|n| n[0] as u64).collect()
            };
            let hidden = set(&lines[&format!("invisibleIds {frame}")]);
            shown.extend(set(&lines["ids"]).difference(&hidden));
        }
        assert_eq!(shown, falls, "frame {frame}");
    }
}

#[test]
fn a_stage_says_its_units_and_refers_to_trees() {
    let place = Place::new();
    let source = place.source();
    let one = windfall_export::Moments { count: 1, ..MOMENTS };
    let selection = select(&source, one, Filter::NONE);
    let mut bytes = Vec::new();
    usd::write_usda(&selection, "./t", &mut bytes, &mut |_| ()).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    for line in
        ["metersPerUnit = 1", "upAxis = \"Y\"", "timeCodesPerSecond = 6", "startTimeCode = 120"]
    {
        assert!(text.contains(line), "{line}");
    }
    assert_eq!(text.matches("instanceable = true").count(), 3);
    assert_eq!(text.matches("\"UsdPreviewSurface\"").count(), text.matches("def Material").count());
    assert_eq!(text.matches('{').count(), text.matches('}').count());
    assert_eq!(usd::identifier("0 my-tree é"), "_0_my_tree__");
}
