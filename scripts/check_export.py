"""Compares exports of one scene with its CSV, which has the numbers of the CPU reference: see scripts/check-export.

    python3 check_export.py usd FILE.usda FILE.csv      validates by OpenUSD; counts, ids and poses at three times
    python3 check_export.py vat FILE.json FILE.csv      decodes by decode_vat.py; poses at three times
    python3 check_export.py table FILE.parquet FILE.csv reads by pyarrow; every pose
"""
import csv, math, os, sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
MOST_METRES, MOST_DEGREES = 1e-3, 0.1


def table(path):
    """Frame -> id -> (position, quaternion x y z w)."""
    frames = {}
    with open(path) as file:
        for row in csv.DictReader(file):
            place = [float(row[k]) for k in ("x", "y", "z")]
            turn = [float(row[k]) for k in ("qx", "qy", "qz", "qw")]
            frames.setdefault(int(row["frame"]), {})[int(row["id"])] = (place, turn)
    return frames


def compare(name, frame, got, expected):
    if got.keys() != expected.keys():
        sys.exit(f"{name}: frame {frame}: {len(got)} leaves for {len(expected)}, or others")
    worst = [0.0, 0.0]
    for leaf, (place, turn) in got.items():
        place0, turn0 = expected[leaf]
        size = math.sqrt(sum(v * v for v in turn))
        turn = [v / size for v in turn]
        chord = min(math.dist(turn, turn0), math.dist([-v for v in turn], turn0))
        off = (math.dist(place, place0), math.degrees(4 * math.asin(min(chord / 2, 1))))
        worst = [max(a, b) for a, b in zip(worst, off)]
    if worst[0] > MOST_METRES or worst[1] > MOST_DEGREES:
        sys.exit(f"{name}: frame {frame}: off by {worst[0]} m, {worst[1]} degrees")
    print(f"{name}: frame {frame}: {len(got)} leaves, off by at most {worst[0] * 1e3:.3f} mm, {worst[1]:.3f} degrees")


def three(frames):
    frames = sorted(frames)
    return frames[0], frames[len(frames) // 2], frames[-1]


def usd(path, expected):
    from pxr import Usd, UsdGeom, UsdValidation

    stage = Usd.Stage.Open(path)
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    for error in errors:
        print(error.GetName(), error.GetMessage())
    if errors:
        sys.exit(f"{path}: {len(errors)} errors")
    print(f"{path}: {len(validators)} validators of OpenUSD {Usd.GetVersion()} find no error")
    for frame in three(expected):
        got = {}
        for prim in stage.Traverse():
            if not prim.IsA(UsdGeom.PointInstancer):
                continue
            leaves = UsdGeom.PointInstancer(prim)
            hidden = set(leaves.GetInvisibleIdsAttr().Get(frame) or [])
            shown = [i for i in leaves.GetIdsAttr().Get(frame) if i not in hidden]
            # Without the prototypes' own transforms, of which there are none; masked as a renderer masks them.
            places = leaves.ComputeInstanceTransformsAtTime(frame, frame)
            assert len(places) == len(shown), (len(places), len(shown))
            for leaf, matrix in zip(shown, places):
                turn = matrix.RemoveScaleShear().ExtractRotationQuat()
                got[leaf] = (list(matrix.ExtractTranslation()), [*turn.GetImaginary(), turn.GetReal()])
        compare(path, frame, got, expected[frame])


def vat(path, expected):
    from decode_vat import poses

    first = min(expected)
    for frame in three(expected):
        got = {leaf: (place, turn) for leaf, shown, place, turn in poses(path, frame - first) if shown}
        compare(path, frame, got, expected[frame])


def parquet(path, expected):
    import pyarrow.parquet

    frames = {}
    for row in pyarrow.parquet.read_table(path).to_pylist():
        place, turn = ([row[k] for k in keys] for keys in (("x", "y", "z"), ("qx", "qy", "qz", "qw")))
        frames.setdefault(row["frame"], {})[row["id"]] = (place, turn)
    for frame in expected:
        compare(path, frame, frames[frame], expected[frame])


if __name__ == "__main__":
    kind, path, expected = sys.argv[1:]
    {"usd": usd, "vat": vat, "table": parquet}[kind](path, table(expected))
