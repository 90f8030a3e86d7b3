"""Poses of leaves from Windfall's vertex animation textures: python3 decode_vat.py FILE.json FRAME

Prints id, shown, x, y, z, qx, qy, qz, qw of each leaf, in metres, Y up. FRAME counts from 0.
"""
import json, os, struct, sys, zlib


def read_exr(data, width, height):
    """Rows of (r, g, b, a) of an OpenEXR file with four float channels and no compression."""
    row = 8 + 16 * width  # y, size, then the channels in the order of their names
    first = len(data) - row * height
    for y in range(height):
        floats = struct.unpack_from(f"<{4 * width}f", data, first + y * row + 8)
        a, b, g, r = (floats[i * width:(i + 1) * width] for i in range(4))
        yield list(zip(r, g, b, a))


def read_png(data, width, height):
    """Rows of (r, g, b, a), 0 to 1, of a PNG with 16 bits a channel and no filter."""
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        packed += data[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += 12 + size
    lines = zlib.decompress(packed)
    for y in range(height):
        n = struct.unpack_from(f">{4 * width}H", lines, y * (1 + 8 * width) + 1)
        yield [tuple(v / 65535 for v in n[4 * x:4 * x + 4]) for x in range(width)]


def poses(path, frame):
    vat = json.load(open(path))
    axes, unit, columns, frames = vat["axes"], vat["unitsPerMetre"], vat["columns"], vat["frames"]
    read = read_exr if vat["encoding"] == "float32" else read_png
    files = [open(os.path.join(os.path.dirname(path), vat[k]["file"]), "rb").read() for k in ("position", "rotation")]
    places, turns = (list(read(f, vat["width"], vat["height"])) for f in files)
    low, high, (a, b) = vat["position"]["low"], vat["position"]["high"], (vat["rotation"]["low"], vat["rotation"]["high"])
    # The axes are a permutation with signs: their transpose undoes them; a mirror turns rotations round.
    back = lambda v: [sum(axes[row][i] * v[row] for row in range(3)) for i in range(3)]
    mirror = 1 if vat["engine"] == "godot" else -1
    for i, leaf in enumerate(vat["ids"]):
        row, column = i // columns * frames + frame, i % columns
        x, y, z, shown = places[row][column]
        place = back([(l + v * (h - l)) / unit for v, l, h in zip((x, y, z), low, high)])
        *q, w = (a + v * (b - a) for v in turns[row][column])
        yield leaf, shown, place, [mirror * v for v in back(q)] + [w]


if __name__ == "__main__":
    for leaf, shown, place, turn in poses(sys.argv[1], int(sys.argv[2])):
        print(leaf, int(shown), *place, *turn)
