"""What the tests of faults share: models, runs and what they leave behind.

usage of each test: NAME_test.py PROGRAM SOURCE_FOLDER FAIL_ALLOCATION ODD_SYSTEM   (the last two to be preloaded, or -)
"""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM, SOURCE = (os.path.abspath(path) for path in sys.argv[1:3])
FAIL_ALLOCATION, ODD_SYSTEM = sys.argv[3:5]
RUN_AWAY = 120.0  # seconds; no run here takes a tenth of that on a machine that does anything else


def preload(library, **settings):
    """The environment of a program with that library; skips the test where it cannot be had."""
    if library == "-":
        raise unittest.SkipTest("NOT TESTED: libraries are not preloaded into programs with sanitizers")
    return dict(os.environ, LD_PRELOAD=library, **{name: str(value) for name, value in settings.items()})


def write_box(path, cells):
    """The unit cube with cells x cells squares a side, each cut in two: grids are left to TetGen."""
    numbers, faces = {}, []

    def number(point):
        return numbers.setdefault(point, len(numbers))

    for axis in range(3):
        for side in (0, cells):
            for i in range(cells):
                for j in range(cells):
                    corners = []
                    for u, v in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        point = [0, 0, 0]
                        point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3] = side, u, v
                        corners.append(number(tuple(point)))
                    if side == 0:
                        corners.reverse()
                    faces += [(corners[0], corners[1], corners[2]), (corners[0], corners[2], corners[3])]
    with open(path, "w", encoding="ascii") as file:
        file.write(f"OFF\n{len(numbers)} {len(faces)} 0\n")
        for point in numbers:
            file.write(" ".join(repr(x / cells) for x in point) + "\n")
        for face in faces:
            file.write("3 %d %d %d\n" % face)


def children_of(process):
    found = []
    try:
        for task in os.listdir(f"/proc/{process}/task"):
            with open(f"/proc/{process}/task/{task}/children", encoding="ascii") as file:
                found += [int(word) for word in file.read().split()]
    except (FileNotFoundError, ProcessLookupError):
        pass
    return found


def runs(process):
    """Whether it does; zombies do not."""
    try:
        with open(f"/proc/{process}/stat", encoding="ascii") as file:
            return file.read().rsplit(")", 1)[1].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return False


def gone(process):
    """Waits some seconds for a process that is ending: where many run it needs a while to get a processor."""
    for _ in range(1000):
        if not runs(process):
            return True
        time.sleep(0.005)
    return False


def as_shells_say(code):
    return 128 - code if code < 0 else code


class Faults(unittest.TestCase):
    """A folder with a worm that bites its tail, its mesh, a grid of a box, and a folder for what is written."""

    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.folder = cls.holder.name
        cls.worm, cls.mesh, cls.box = (os.path.join(cls.folder, name) for name in ("worm.off", "worm.mesh", "box.off"))
        subprocess.run([sys.executable, "-B", os.path.join(SOURCE, "scripts/make_sample"), cls.worm, "420", "8"], check=True,
                       capture_output=True)
        subprocess.run([PROGRAM, "mesh", cls.worm, "-o", cls.mesh, "-q"], check=True)
        write_box(cls.box, 12)

    @classmethod
    def tearDownClass(cls):
        cls.holder.cleanup()

    def setUp(self):
        out = tempfile.TemporaryDirectory()
        self.addCleanup(out.cleanup)
        self.out = out.name

    def commands(self):
        """Of each command the words, without the program."""
        return {"mesh": ["mesh", self.worm, "-o", f"{self.out}/o.mesh", "--report", f"{self.out}/r.json"],
                "flow": ["mesh", self.worm, "--preset", "flow", "-o", f"{self.out}/o.mesh", "--report", f"{self.out}/r.json"],
                "inspect": ["inspect", self.worm, "--json"],
                "verify": ["verify", self.worm, self.mesh],
                "convert": ["convert", self.mesh, f"{self.out}/o.vtu"],
                "prepare": ["prepare", self.worm, "--all", "-o", f"{self.out}/o.off", "--report", f"{self.out}/r.json"],
                "repair": ["repair", self.worm, "-o", f"{self.out}/o.off", "--report", f"{self.out}/r.json"]}

    def run_program(self, words, program=PROGRAM, **how):
        return subprocess.run([program, *words], capture_output=True, timeout=RUN_AWAY, check=False, stdin=subprocess.DEVNULL,
                              **how)

    def left(self):
        return sorted(os.listdir(self.out))

    def report(self):
        with open(f"{self.out}/r.json", encoding="utf-8") as file:
            return json.load(file)

    def expect_one_sentence(self, run):
        said = run.stderr.decode(errors="replace")
        self.assertRegex(said, r"(^|\n)overtet: [^\n]+[.?]\n$")

    def expect_right_mesh(self, surface, mesh):
        checked = self.run_program(["verify", surface, mesh])
        self.assertEqual(checked.returncode, 0, checked.stderr)


def default_signals():
    """For the child: whoever started the tests may have ignored some."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def main():
    unittest.main(argv=[sys.argv[0]])
