"""Files of all formats say the same, and what cannot be read is refused."""

import os
import struct
import tempfile
import unittest

from support import TET_FACES, TET_POINTS, off_text
from witness_checker.errors import Unreadable
from witness_checker.files import read_surface

POINTS = [(0.1, -1e-30, 1 / 3), *TET_POINTS[1:]]
OBJ = "# made for a test\n" + "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in POINTS)
PLY_HEAD = (
    "ply\nformat {} 1.0\nelement vertex 4\nproperty {} x\nproperty {} y\nproperty {} z\nproperty uchar red\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
)


def rounded(x):
    return struct.unpack("f", struct.pack("f", x))[0]


def binary_ply(order):
    name = "binary_little_endian" if order == "<" else "binary_big_endian"
    body = b"".join(struct.pack(order + "3dB", *p, 7) for p in POINTS)
    body += b"".join(struct.pack(order + "B3i", 3, *f) for f in TET_FACES)
    return PLY_HEAD.format(name, *["double"] * 3).encode() + body


def text_ply(number):
    rows = [" ".join(map(repr, p)) + " 7" for p in POINTS] + ["3 " + " ".join(map(str, f)) for f in TET_FACES]
    return (PLY_HEAD.format("ascii", *[number] * 3) + "\n".join(rows) + "\n").encode()


def stl(binary):
    triangles = [[POINTS[v] for v in f] for f in TET_FACES]
    if binary:
        facets = [struct.pack("<12fH", 0, 0, 0, *(x for p in t for x in p), 0) for t in triangles]
        return b" " * 80 + struct.pack("<I", 4) + b"".join(facets)
    loops = ("".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in t) for t in triangles)
    return ("solid s\n" + "".join(f"facet normal 0 0 0\nouter loop\n{x}endloop\nendfacet\n" for x in loops)).encode()


class Files(unittest.TestCase):
    def read(self, data, name="s.off"):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, name)
            with open(path, "wb") as file:
                file.write(data if isinstance(data, bytes) else data.encode())
            return read_surface(path)

    def same(self, data, name="s.off", points=POINTS):
        self.assertEqual(self.read(data, name), (list(points), TET_FACES))

    def test_formats(self):
        off = off_text((POINTS, TET_FACES))
        self.same(off)
        self.same(off.replace("OFF\n", "OFF # a comment\n\n"))
        self.same(off.replace("OFF\n", "OFF "))
        self.same("C" + "".join(line + (" 1 2 3 4" if " " in line else "") + "\n" for line in off.splitlines()))
        self.same(OBJ + "".join(f"f {a + 1} {b + 1}/3 {c + 1}//2\n" for a, b, c in TET_FACES), "s.obj")
        self.same(OBJ + "".join(f"f {a - 4} {b - 4} {c - 4}\n" for a, b, c in TET_FACES), "s.OBJ")
        for order in "<>":
            self.same(binary_ply(order), "any.name")
        self.same(text_ply("double"))
        self.same(text_ply("float"), points=[tuple(map(rounded, p)) for p in POINTS])

    def test_stl(self):
        for binary in (False, True):
            points, faces = self.read(stl(binary), "s.stl")
            expected = [tuple(map(rounded, p)) for p in POINTS] if binary else POINTS
            self.assertEqual(sorted(points), sorted(expected))
            triangles = [tuple(points[v] for v in f) for f in faces]
            self.assertEqual(triangles, [tuple(expected[v] for v in f) for f in TET_FACES])

    def test_unreadable(self):
        off = off_text((POINTS, TET_FACES))
        wrong = [
            ("", "s.off"), ("OFF\n3 1 0\n0 0 0\n", "s.off"), ("4OFF\n" + off[4:], "s.off"),
            (off.replace("0.1", "x"), "s.off"), (off.replace("0.1", "nan"), "s.off"), (off.replace("0.1", "inf"), "s.off"),
            (off.replace("3 0 2 1", "3 0 2 9"), "s.off"), (off.replace("3 0 2 1", "4 0 2 1 3"), "s.off"),
            (OBJ, "s.obj"), (OBJ + "f 1 2\n", "s.obj"), (binary_ply("<")[:-1], "s.ply"), (text_ply("double")[:-9], "s.ply"),
            (text_ply("number"), "s.ply"), (text_ply("float").replace(b"0.1", b"1e300"), "s.ply"),
            (stl(False).replace(b"vertex 1.0", b"x 1.0", 1), "s.stl"),
        ]  # fmt: skip
        for data, name in wrong:
            with self.subTest(data=data[:60], name=name), self.assertRaises(Unreadable):
                self.read(data, name)
        with self.assertRaises(Unreadable):
            read_surface("/nowhere/s.off")


if __name__ == "__main__":
    unittest.main()
