#!/usr/bin/python3
"""Draws pictures with `overtet view --png`, without a display, and looks at their pixels.

usage: picture_test.py OVERTET

Exit code 77 where overtet-picture was not built.
"""
import os
import signal
import stat
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

ROOT = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..")
OVERTET = ""
WHITE = (255, 255, 255)
HERE = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}

TWO_TETS = """MeshVersionFormatted 2
Dimension 3
Vertices
8
0 0 0 0
1 0 0 0
0 1 0 0
0 0 1 0
0 0 5 0
1 0 5 0
0 1 5 0
0 0 6 0
Tetrahedra
2
1 2 3 4 1
5 6 7 8 2
End
"""


class Picture:
    """A PNG file, by its own words: every checksum is looked at."""

    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        assert data[:8] == b"\x89PNG\r\n\x1a\n"
        at, kinds, pixels = 8, [], b""
        while at < len(data):
            size, kind = struct.unpack(">I4s", data[at:at + 8])
            body = data[at + 8:at + 8 + size]
            assert struct.unpack(">I", data[at + 8 + size:at + 12 + size])[0] == zlib.crc32(kind + body)
            kinds.append(kind)
            if kind == b"IHDR":
                self.width, self.height, depth, colours, *rest = struct.unpack(">IIBBBBB", body)
                assert (depth, colours, rest) == (8, 2, [0, 0, 0])
            elif kind == b"IDAT":
                pixels += body
            at += 12 + size
        assert kinds[0] == b"IHDR" and kinds[-1] == b"IEND" and b"IDAT" in kinds
        pixels = zlib.decompress(pixels)
        row = 3 * self.width + 1
        assert len(pixels) == row * self.height
        self.rows = []
        for y in range(self.height):
            line = pixels[y * row:(y + 1) * row]
            assert line[0] == 1  # differences to the left
            out, last = [], [0, 0, 0]
            for x in range(1, row, 3):
                last = [(last[k] + line[x + k]) & 255 for k in range(3)]
                out.append(tuple(last))
            self.rows.append(out)

    def colours(self):
        return {pixel for row in self.rows for pixel in row}

    def count(self, test):
        return sum(1 for row in self.rows for pixel in row if test(pixel))


def orange(pixel):  # any shade of layer_colour(2)
    r, g, b = pixel
    return r > 80 and abs(g / r - .55 / .9) < .04 and abs(b / r - .1 / .9) < .05


def reddish(pixel):  # marks, also where they shine through what is blue
    return pixel[0] > pixel[1] + 30


class Pictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.surface, cls.mesh = cls.file("worm.off"), cls.file("worm.vtu")
        subprocess.run([os.path.join(ROOT, "scripts", "make_sample"), cls.surface], check=True)
        subprocess.run([OVERTET, "mesh", cls.surface, "-o", cls.mesh, "--quiet"], check=True)
        with open(cls.file("two.mesh"), "w", encoding="ascii") as file:
            file.write(TWO_TETS)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def file(cls, name):
        return os.path.join(cls.folder.name, name)

    def draw(self, name, *words, to="out.png", size="240x180"):
        done = subprocess.run([OVERTET, "view", name, "--png", self.file(to), "--size", size, *words], env=HERE,
                              stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return Picture(self.file(to))

    def fails(self, code, *words, **more):
        done = subprocess.run([OVERTET, "view", *words], env=HERE, stderr=subprocess.PIPE, text=True, check=False, **more)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        return done.stderr

    def test_it_has_the_size_that_was_asked_for(self):
        for size in ((240, 180), (33, 517)):
            picture = self.draw(self.mesh, size="%dx%d" % size)
            self.assertEqual((picture.width, picture.height), size)

    def test_a_mesh_is_seen_on_white(self):
        picture = self.draw(self.mesh)
        self.assertGreater(len(picture.colours()), 50)
        for y in (0, -1):
            self.assertEqual(set(picture.rows[y]), {WHITE})
        seen = picture.count(lambda pixel: pixel != WHITE) / (240 * 180)
        self.assertTrue(.1 < seen < .9, seen)

    def test_the_overlap_is_coloured(self):
        self.assertGreater(self.draw(self.mesh, "--cut", "z").count(orange), 300)
        self.assertGreater(self.draw(self.mesh, "--apart", ".6").count(orange), 300)
        self.assertEqual(self.draw(self.mesh, "--cut", "z", "--colour", "region").count(orange), 0)
        for colour in ("label", "angle", "plain"):
            self.draw(self.mesh, "--colour", colour)

    def test_the_cut_and_the_eye_change_it(self):
        pictures = [hash(str(self.draw(self.mesh, *words).rows)) for words in (
            [], ["--cut", "x"], ["--cut", "x=.3"], ["--cut", "y"], ["--cut", "z=0.5"], ["--eye", "1,0,0"], ["--eye", "0,-1,0"],
            ["--apart", ".7"])]
        self.assertEqual(len(set(pictures)), len(pictures))

    def test_what_is_in_front_hides_the_rest(self):
        def middle(eye):
            picture = self.draw(self.file("two.mesh"), "--colour", "region", "--eye", eye)
            return next(row[120] for row in picture.rows[90:] if row[120] != WHITE)
        blue_is_more = lambda p: p[2] - p[0]
        front, back = middle("0,0,1"), middle("0,0,-1")
        # Region 2 is nearer to an eye at z, region 1 to one at -z: green-blue there, orange here.
        self.assertGreater(blue_is_more(front), 0, front)
        self.assertLess(blue_is_more(back), 0, back)

    def test_surfaces_show_where_they_cross_themselves(self):
        picture = self.draw(self.surface, size="480x360")
        self.assertGreater(picture.count(reddish), 200)
        self.draw(self.surface, "--cut", "z", "--apart", ".3")

    def test_the_same_bytes_each_time(self):
        self.draw(self.mesh, "--cut", "y", to="one.png")
        self.draw(self.mesh, "--cut", "y", "--threads", "1", to="other.png")
        with open(self.file("one.png"), "rb") as one, open(self.file("other.png"), "rb") as other:
            self.assertEqual(one.read(), other.read())

    def test_a_page_and_a_picture_at_once(self):
        self.draw(self.mesh, "-o", self.file("page.html"), "--quiet")
        self.assertGreater(os.path.getsize(self.file("page.html")), 100000)

    def test_a_surface_that_cannot_be_meshed_is_drawn(self):
        with open(self.surface, encoding="ascii") as file:
            lines = file.read().splitlines()
        counts = lines[1].split()
        lines[1] = f"{counts[0]} {int(counts[1]) - 1} 0"
        with open(self.file("open.off"), "w", encoding="ascii") as file:
            file.write("\n".join(lines[:-1]) + "\n")
        self.draw(self.file("open.off"))

    def test_what_is_asked_wrongly(self):
        out = self.file("never.png")
        for words in (["--size", "1200"], ["--size", "0x10"], ["--size", "10000x10000"], ["--size", "axb"], ["--cut", "w"],
                      ["--cut", "x=2"], ["--cut", "x.5"], ["--eye", "1,2"], ["--eye", "0,0,0"], ["--eye", "1,nan,0"],
                      ["--eye", "1,0,0,"], ["--apart", "2"], ["--colour", "blue"]):
            self.fails(2, self.mesh, "--png", out, *words)
        self.fails(2, self.mesh)
        self.fails(2, self.mesh, "-o", self.file("a.html"), "--cut", "x")
        self.fails(2, self.mesh, "--png", self.mesh)
        self.fails(2, self.mesh, "--png", self.file("a"), "-o", self.file("a"))
        self.assertIn("no layers", self.fails(2, self.surface, "--png", out, "--colour", "layers"))
        self.assertIn("no labels", self.fails(2, self.file("two.mesh"), "--png", out, "--colour", "label"))
        self.fails(7, self.mesh, "--png", self.file("no/such/out.png"))
        self.assertFalse(os.path.exists(out))

    def with_helper(self, script):
        """A program folder in which overtet-picture is something else, or is missing."""
        folder = tempfile.mkdtemp(dir=self.folder.name)
        os.link(OVERTET, os.path.join(folder, "overtet")) if os.stat(OVERTET).st_dev == os.stat(folder).st_dev else \
            subprocess.run(["cp", OVERTET, folder], check=True)
        path = os.path.join(folder, "overtet-picture")
        with open(path, "w", encoding="ascii") as file:
            file.write(script)
        os.chmod(path, stat.S_IRWXU)
        return os.path.join(folder, "overtet")

    def test_a_helper_that_fails_is_said(self):
        out = self.file("never.png")
        for script, said in (("#!/bin/sh\necho noise >&2\necho 'no renderer here' >&2\nexit 1\n", "no renderer here."),
                             ("#!/bin/sh\nkill -SEGV $$\n", "signal 11"), ("#!/bin/sh\nexit 0\n", "no whole picture"),
                             ("#!/no/such/shell\n", "No such file")):
            program = self.with_helper(script)
            done = subprocess.run([program, "view", self.mesh, "--png", out], stderr=subprocess.PIPE, text=True, check=False)
            self.assertEqual(done.returncode, 7, done.stderr)
            self.assertIn(said, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1)
        self.assertFalse(os.path.exists(out))

    def test_a_helper_that_hangs_is_ended(self):
        program = self.with_helper("#!/bin/sh\necho $$ > \"$0.pid\"\nexec sleep 1000\n")
        done = subprocess.run([program, "view", self.mesh, "--png", self.file("never.png"), "--time-limit", "1"],
                              stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(done.returncode, 6, done.stderr)
        work = subprocess.Popen([program, "view", self.mesh, "--png", self.file("never.png")], stderr=subprocess.PIPE)
        pid = program + "-picture.pid"
        os.remove(pid) if os.path.exists(pid) else None
        while not os.path.exists(pid) or not os.path.getsize(pid):
            time.sleep(.02)
        work.send_signal(signal.SIGINT)
        self.assertEqual(work.wait(), 130)
        work.stderr.close()
        with open(pid, encoding="ascii") as file:
            child = int(file.read())
        self.assertFalse(os.path.exists(f"/proc/{child}"))

    def test_a_build_without_pictures_says_so(self):
        program = self.with_helper("")
        os.remove(program + "-picture")
        if os.path.exists("/usr/libexec/overtet/overtet-picture"):
            self.skipTest("overtet-picture is installed")
        done = subprocess.run([program, "view", self.mesh, "--png", self.file("never.png")], stderr=subprocess.PIPE,
                              text=True, check=False)
        self.assertEqual(done.returncode, 7)
        for word in ("no pictures", "overtet-pictures", "libvtk9-dev"):
            self.assertIn(word, done.stderr)


def main():
    global OVERTET
    OVERTET = os.path.abspath(sys.argv[1])
    if not os.path.exists(OVERTET + "-picture"):
        print("SKIPPED: no pictures are drawn: install libvtk9-dev and libegl-dev (scripts/setup --pictures) and build again")
        return 77
    result = unittest.TextTestRunner(verbosity=2).run(unittest.defaultTestLoader.loadTestsFromTestCase(Pictures))
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
