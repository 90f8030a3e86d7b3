//! Which leaves are selected, and where they are.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{MOMENTS, Place, reference, select};
use std::collections::{BTreeMap, BTreeSet};
use windfall_core::glam::Vec3;
use windfall_export::table::{self, name};
use windfall_export::{Filter, LeafId, Moments, Parts};

fn only(parts: &str) -> Filter {
    Filter { parts: parts.parse().unwrap(), ..Filter::NONE }
}

#[test]
fn every_leaf_is_where_the_reference_has_it() {
    let place = Place::new();
    let source = place.source();
    let selection = select(&source, MOMENTS, Filter::NONE);
    assert_eq!(selection.len(), 3 * 400);
    let mut phases = BTreeSet::new();
    for time in [20.0, 24.3, 29.8] {
        let expected = reference(&source, time);
        let got: BTreeMap<LeafId, _> = selection.at(time).map(|s| (s.id, s)).collect();
        assert!(got.keys().eq(expected.keys()), "each leaf once");
        for (id, leaf) in &expected {
            let state = got[id];
            assert_eq!(name(state.phase), leaf.phase, "{id} at {time}");
            assert!(state.position.distance(leaf.position) < 1e-6, "{id} at {time}");
            assert!(common::angle(state.orientation, leaf.orientation) < 0.01, "{id} at {time}");
            assert_eq!(state.scale, leaf.scale);
            phases.insert(leaf.phase);
        }
    }
    assert_eq!(phases.len(), 3, "{phases:?}");
}

#[test]
fn parts_divide_the_leaves_and_ids_stay() {
    let place = Place::new();
    let source = place.source();
    let one = Moments { count: 1, ..MOMENTS };
    let time = one.time(one.first);
    let ids = |parts: &str| -> BTreeSet<LeafId> {
        select(&source, one, only(parts)).at(time).map(|s| s.id).collect()
    };
    let [hanging, falling, landed] = ["hanging", "falling", "landed"].map(ids);
    assert!(hanging.len() > 100 && falling.len() > 20 && landed.len() > 100);
    assert_eq!(hanging.len() + falling.len() + landed.len(), 1200);
    assert_eq!(ids("hanging,falling,landed").len(), 1200);
    // Ten seconds later some of those that hung fall or lie, by the same names; none has gone back.
    let later = reference(&source, time + 10.0);
    let fell = hanging.iter().filter(|id| later[id].phase != "hanging").count();
    assert!(fell > 50, "{fell}");
    assert!(landed.iter().all(|id| later[id].phase == "landed"));
}

/// With and without hanging leaves, leaves are found in two ways.
#[test]
fn a_leaf_is_selected_if_it_is_shown_in_one_of_the_frames() {
    let place = Place::new();
    let source = place.source();
    let frames: Vec<_> =
        MOMENTS.frames().map(|frame| reference(&source, MOMENTS.time(frame))).collect();
    for parts in ["falling", "landed", "falling,hanging", "hanging"] {
        let shown = |id: &LeafId| {
            frames.iter().any(|frame| parts.split(',').any(|part| part == frame[id].phase))
        };
        let expected: BTreeSet<LeafId> = frames[0].keys().copied().filter(shown).collect();
        let selection = select(&source, MOMENTS, only(parts));
        let got: BTreeSet<LeafId> = (0..selection.len()).map(|i| selection.id(i)).collect();
        assert_eq!(got, expected, "{parts}");
        for (frame, expected) in MOMENTS.frames().zip(&frames) {
            let shown = selection.at(MOMENTS.time(frame)).count();
            let of = expected.values().filter(|w| parts.contains(w.phase)).count();
            assert_eq!(shown, of, "{parts} in frame {frame}");
        }
        for group in selection.groups().iter().filter(|group| !group.moves) {
            let first = |i: usize| frames[0][&selection.id(i)];
            let still = |i: usize| frames.iter().all(|f| f[&selection.id(i)] == first(i));
            assert!(group.leaves.clone().all(still), "{parts}");
        }
    }
}

#[test]
fn a_box_and_a_number_take_the_leaves_that_they_say() {
    let place = Place::new();
    let source = place.source();
    let frames: Vec<_> =
        MOMENTS.frames().map(|frame| reference(&source, MOMENTS.time(frame))).collect();
    let (low, high) = (Vec3::new(-3.0, -2.0, -9.0), Vec3::new(9.0, 2.0, 3.0));
    let inside = |p: Vec3| p.cmpge(low).all() && p.cmple(high).all();
    let filter = Filter { within: Some((low, high)), ..only("falling,landed") };
    let selection = select(&source, MOMENTS, filter);
    let expected: BTreeSet<LeafId> = (frames[0].keys().copied())
        .filter(|id| frames.iter().any(|f| f[id].phase != "hanging" && inside(f[id].position)))
        .collect();
    let got: BTreeSet<LeafId> = (0..selection.len()).map(|i| selection.id(i)).collect();
    assert!((50..900).contains(&expected.len()), "{}", expected.len());
    // A leaf that lies is lifted by some millimetres: the box is of its place without that.
    assert!(got.symmetric_difference(&expected).count() <= 2);

    let eye = Vec3::new(0.0, 1.0, 20.0);
    let apart = |id: &LeafId| {
        let of = |w: &common::Where| (w.phase == "falling").then(|| w.position.distance(eye));
        frames.iter().filter_map(|f| of(&f[id])).fold(f32::INFINITY, f32::min)
    };
    for most in [0, 1, 40, 10_000] {
        let selection = select(&source, MOMENTS, Filter { most: Some(most), ..only("falling") });
        let all = select(&source, MOMENTS, only("falling")).len();
        assert_eq!(selection.len(), most.min(all));
        let got: BTreeSet<LeafId> = (0..selection.len()).map(|i| selection.id(i)).collect();
        let farthest = got.iter().map(&apart).fold(0.0, f32::max);
        let nearer = frames[0].keys().filter(|id| apart(id) < farthest - 0.02).count();
        assert!(nearer <= got.len(), "{nearer} are nearer than {farthest}, {} kept", got.len());
    }
}

#[test]
fn velocities_are_what_positions_change_by() {
    let place = Place::new();
    let source = place.source();
    let selection = select(&source, MOMENTS, only("falling"));
    let mut fastest = 0.0f32;
    for i in 0..selection.len() {
        let (before, after) = (selection.state(i, 24.99), selection.state(i, 25.01));
        let steady = name(before.phase) == "falling" && name(after.phase) == "falling";
        let velocity = selection.velocity(i, 25.0);
        if steady {
            let moved = (after.position - before.position) / 0.02;
            assert!(moved.distance(velocity) < 0.35, "{moved} for {velocity}");
        }
        fastest = fastest.max(velocity.length());
    }
    assert!((0.5..8.0).contains(&fastest), "{fastest}");
}

#[test]
fn a_table_reads_back_as_the_same_numbers() {
    let place = Place::new();
    let source = place.source();
    let moments = Moments { first: 150, count: 3, fps: 6.0 };
    let selection = select(&source, moments, only("falling,landed"));
    let mut bytes = Vec::new();
    let mut shares = Vec::new();
    let rows = table::write_csv(&selection, &mut bytes, &mut |share| shares.push(share)).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next().unwrap(), table::COLUMNS.join(","));
    assert_eq!(shares.last(), Some(&1.0));
    let mut read = 0;
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let time: f64 = cells[1].parse().unwrap();
        assert_eq!(time, cells[0].parse::<f64>().unwrap() / 6.0);
        let id = LeafId(cells[2].parse().unwrap());
        assert_eq!([id.tree(), id.leaf()].map(|n| n.to_string()), [cells[3], cells[4]]);
        let expected = selection.at(time).find(|s| s.id == id).unwrap();
        let number = |i: usize| cells[i].parse::<f32>().unwrap();
        assert_eq!(cells[5], name(expected.phase));
        assert_eq!(Vec3::new(number(6), number(7), number(8)), expected.position);
        assert_eq!([9, 10, 11, 12].map(number), expected.orientation.to_array());
        assert_eq!(number(13), expected.scale);
        read += 1;
    }
    assert!(read == rows && rows > 300, "{rows}");
}

#[test]
fn parquet_has_the_rows_of_the_table_in_a_group_a_frame() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    let place = Place::new();
    let source = place.source();
    let moments = Moments { first: 150, count: 3, fps: 6.0 };
    let selection = select(&source, moments, only("falling,hanging"));
    let (mut csv, mut bytes) = (Vec::new(), Vec::new());
    let rows = table::write_csv(&selection, &mut csv, &mut |_| ()).unwrap();
    assert_eq!(table::write_parquet(&selection, &mut bytes, &mut |_| ()).unwrap(), rows);
    let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
    assert_eq!(reader.num_row_groups(), 3);
    let csv = String::from_utf8(csv).unwrap();
    let mut lines = csv.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut read = 0;
    for (row, line) in reader.get_row_iter(None).unwrap().zip(lines) {
        for ((name, value), (known, cell)) in
            row.unwrap().get_column_iter().zip(names.iter().zip(line.split(',')))
        {
            use parquet::record::Field;
            assert_eq!(name, known);
            match value {
                Field::Int(v) => assert_eq!(v.to_string(), cell),
                Field::Long(v) => assert_eq!(v.to_string(), cell),
                Field::Double(v) => assert_eq!(*v, cell.parse::<f64>().unwrap()),
                Field::Float(v) => assert_eq!(*v, cell.parse::<f32>().unwrap()),
                Field::Str(v) => assert_eq!(v, cell),
                other => panic!("{name}: {other}"),
            }
        }
        read += 1;
    }
    assert!(read == rows && rows > 300);
}

#[test]
fn names_of_parts_are_read() {
    assert_eq!("hanging,falling,landed,trees,ground".parse(), Ok(Parts::ALL));
    assert!("falling".parse::<Parts>().unwrap().falling);
    assert_eq!(
        "fallen".parse::<Parts>().unwrap_err(),
        "\"fallen\" is none of hanging, falling, landed, trees, ground"
    );
}
