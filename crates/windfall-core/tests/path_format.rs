//! The binary form of path sets: what is written is read, and anything else is refused without a panic.
#![expect(clippy::unwrap_used, reason = "this is test code")]

use windfall_core::InputErrorKind;
use windfall_core::glam::{Quat, Vec3};
use windfall_core::path::{Analysis, FallPath, Gap, Joint, PathSet, Recording};

/// A leaf that glides down a slope at 30 Hz, with one joint and two starting points.
fn path(samples: usize) -> FallPath {
    let at = |i: usize| Vec3::new(0.01, -0.02, 0.0) * i as f32;
    let positions = (0..samples).map(at).collect();
    let recording = Recording::new("glider", 30.0, positions, vec![Quat::IDENTITY; samples]);
    let joint = Joint {
        from: samples as u32 - 2,
        to: 4,
        blend: 3,
        half_turn: 1 << 28,
        raw: Gap { position: 0.1, ..Gap::default() },
        blended: Gap::default(),
    };
    FallPath::new(recording.unwrap(), Analysis { starts: vec![0, 2], joints: vec![joint] }).unwrap()
}

#[test]
fn a_set_is_read_as_it_was_written() {
    let set = PathSet::new(vec![path(40), path(100).renamed("other")]).unwrap();
    let again = PathSet::read("set", &set.to_bytes()).unwrap();
    assert_eq!(again, set);
    assert_eq!(again.groups(), ["glider", "other"]);
    assert_eq!(again.paths()[0].analysis().joints[0].half_turn, 1 << 28);
}

#[test]
fn bad_path_sets_are_refused() {
    let bytes = PathSet::new(vec![path(40)]).unwrap().to_bytes();
    // Every prefix and every version but the right one; never a panic.
    for n in 0..bytes.len() {
        assert!(PathSet::read("set", &bytes[..n]).is_err(), "{n}");
    }
    let message = |b: &[u8]| PathSet::read("set", b).unwrap_err().to_string();
    let mut longer = bytes.clone();
    longer.push(0);
    assert_eq!(message(&longer), "set: 1 bytes after the end");
    let mut newer = bytes.clone();
    newer[8] = 2;
    assert_eq!(message(&newer), "set: version 2; this program reads version 1");
    assert_eq!(
        message(b"(version: 1)"),
        "set: not a binary path set: it would begin with \"WFPATHS\""
    );
    // Count of samples, after version, count of paths, "glider" and the rate: far more than there are.
    let mut greedy = bytes.clone();
    let at = 8 + 4 + 4 + 4 + 6 + 4;
    greedy[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(message(&greedy), "set: claims 4294967295 samples, more than the file holds");
    for i in 0..bytes.len() {
        for bit in [0, 7] {
            let mut broken = bytes.clone();
            broken[i] ^= 1 << bit;
            let _ = PathSet::read("set", &broken);
        }
    }
}

/// An analysis that is not of the recording is refused, whoever made it.
#[test]
fn a_path_has_an_analysis_of_its_own_samples() {
    let good = path(40);
    let refused = |edit: fn(&mut Analysis)| {
        let mut analysis = good.analysis().clone();
        edit(&mut analysis);
        let error = FallPath::new(good.recording().clone(), analysis).unwrap_err();
        assert_eq!(error.kind, InputErrorKind::OutOfRange);
        error.to_string()
    };
    let no_points = "glider: a path needs a starting point and a continuity point";
    assert_eq!(refused(|a| a.starts.clear()), no_points);
    assert_eq!(refused(|a| a.joints.clear()), no_points);
    let outside =
        "glider: continuity point 0: must lead from a sample of the path to an earlier one";
    assert_eq!(refused(|a| a.joints[0].from = 40), outside);
    assert_eq!(refused(|a| a.joints[0].to = 0), outside);
    assert_eq!(refused(|a| a.joints[0].from = 4), outside);
    let blends = "glider: continuity point 0: blends over more samples than there are";
    assert_eq!(refused(|a| a.joints[0].blend = 0), blends);
    assert_eq!(refused(|a| a.joints[0].blend = 5), blends);
    assert_eq!(
        refused(|a| a.joints[0].raw.velocity = f32::NAN),
        "glider: continuity point 0: a gap is NaN or infinite"
    );
    let starts =
        "glider: starting points: must ascend and lie before the first continuity point's blend";
    assert_eq!(refused(|a| a.starts = vec![2, 2]), starts);
    assert_eq!(refused(|a| a.starts = vec![0, 35]), starts);
}
