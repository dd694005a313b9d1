"""Smaller models that fail in the same way, and the script as a whole, with made-up programs."""

import json
import os
import subprocess
import tempfile
import time
import unittest

import support
from hard_models import judge, kinds
from hard_models.judge import Verdict
from hard_models.kinds import Model
from hard_models.minimise import Minimiser
from hard_models.surface import faults, joined, off_text, read_off
from support import bar, program, spiral


def asked(what, fails):
    """A judge without a program."""
    return lambda model: Verdict(what, failed=bool(fails(model)))


def gone(process):
    """Whether it ends within 20 s. (What was killed stays for a moment, until its parent has looked.)"""
    for _ in range(1000):
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.02)
    return False


class Minimised(unittest.TestCase):
    def test_surfaces(self):
        """A crash that needs a far vertex: the smallest closed surface is left, with it."""
        surface = kinds.make("pose", 1).surface
        far = max(p[0] for p in surface.points)
        fails = asked(judge.CRASH, lambda m: any(p[0] == far for p in m.surface.points))
        small = Minimiser(fails, 2000).minimise(Model(surface), judge.CRASH).surface
        self.assertEqual(faults(small), "")
        self.assertEqual(len(small.faces), 4)

    def test_components(self):
        one, two = bar(1).surface, bar(3).surface
        fails = asked(judge.CRASH, lambda m: len(m.surface.faces) >= 20)
        small = Minimiser(fails, 1).minimise(Model(joined(one, two, one)), judge.CRASH).surface
        self.assertEqual(len(small.faces), len(joined(one, two, one).faces))  # the first run says no
        small = Minimiser(fails, 2).minimise(Model(joined(one, two, one)), judge.CRASH).surface
        self.assertEqual(len(small.faces), len(two.faces))

    def test_solids_stay_solids(self):
        """"Unsolved", and only if a tet is there: that tet is left."""
        for kind in ("grown", "fan", "copies"):
            model = kinds.make(kind, 2)
            tet = model.solid.tets[-1]
            corners = {model.solid.points[v] for v in tet}
            fails = asked(judge.UNSOLVED, lambda m, c=corners: any({m.solid.points[v] for v in t} == c
                                                                   for t in m.solid.tets))
            small = Minimiser(fails, 2000).minimise(model, judge.UNSOLVED)
            self.assertEqual(small.solid.faults(), "")
            self.assertEqual(len(small.solid.tets), 1, kind)

    def test_solids_that_crash_may_become_surfaces(self):
        solid = spiral(6)
        fails = asked(judge.CRASH, lambda m: len(m.surface.points) >= 5)
        small = Minimiser(fails, 500).minimise(Model(solid.surface, solid), judge.CRASH)
        self.assertEqual((len(small.surface.faces), faults(small.surface)), (6, ""))

    def test_other_failures_do_not_count(self):
        model = kinds.make("grown", 1)
        fails = asked(judge.CRASH, lambda m: True)
        self.assertIs(Minimiser(fails, 100).minimise(model, judge.UNSOLVED), model)

    def test_runs_are_counted_and_results_the_same(self):
        texts = []
        for _ in range(2):
            runs = []
            fails = asked(judge.CRASH, lambda m, r=runs: r.append(1) or len(m.surface.faces) > 30)
            model = kinds.make("wave", 3)
            texts.append(off_text(Minimiser(fails, 15).minimise(model, judge.CRASH).surface))
            self.assertLessEqual(len(runs), 15)
        self.assertEqual(texts[0], texts[1])


class Script(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def stress(self, *arguments):
        done = subprocess.run([support.SCRIPT, *arguments], capture_output=True, text=True, check=False, cwd=self.folder)
        return done.returncode, done.stdout, done.stderr

    def test_a_failure_is_kept(self):
        path = program(self.folder, "sys.exit(70 if faces() > 11 else 4)")
        keep, rows = os.path.join(self.folder, "kept"), os.path.join(self.folder, "rows.json")
        code, said, _ = self.stress("--program", path, "--kinds", "fan", "wave", "--seeds", "2", "--keep", keep,
                                    "--minimise", "--runs", "60", "--json", rows)
        self.assertEqual(code, 1)
        self.assertIn("fan           1 models, 1 failed: crash 1", said)
        for name in ("fan_2", "wave_2"):
            surface, comments = read_off(os.path.join(keep, name + ".off"))
            self.assertEqual(faults(surface), "")
            self.assertLess(11, len(surface.faces))
            self.assertLess(len(surface.faces), 30)
            self.assertIn(f"{name}: crash", comments[0])
        with open(rows, encoding="utf-8") as file:
            self.assertEqual([(r["name"], r["verdict"], r["failed"]) for r in json.load(file)],
                             [("fan_2", "crash", True), ("wave_2", "crash", True)])
        code, said, _ = self.stress("--program", path, "--again", keep)
        self.assertEqual((code, said.count("crash")), (1, 3))
        other = program(self.folder, "sys.exit(4)", "other")
        self.assertEqual(self.stress("--program", other, "--again", os.path.join(keep, "wave_2.off"))[0], 0)

    def test_what_has_a_mesh_is_remembered(self):
        path = program(self.folder, "sys.exit(4)")
        keep = os.path.join(self.folder, "kept")
        self.assertEqual(self.stress("--program", path, "--kinds", "grown", "--seeds", "1-1", "--keep", keep)[0], 1)
        self.assertEqual(sorted(os.listdir(keep)), ["grown_1.mesh", "grown_1.off"])
        self.assertEqual(self.stress("--program", path, "--again", keep)[0], 1)
        self.assertEqual(self.stress("--program", path, "--kinds", "bend", "--seeds", "1")[0], 0)

    def test_interrupted(self):
        """The program is ended, and the smallest model so far is kept."""
        child = os.path.join(self.folder, "child")
        body = (f"open({child!r} + '.new', 'w').write(str(os.getpid()))\n"
                f"os.rename({child!r} + '.new', {child!r} + str(faces() < 100))\n"
                "time.sleep(0 if faces() >= 100 else 60)\nsys.exit(70)")
        keep = os.path.join(self.folder, "kept")
        with subprocess.Popen([support.SCRIPT, "--program", program(self.folder, body), "--kinds", "pose", "--seeds", "1",
                               "--keep", keep, "--minimise"], stdout=subprocess.DEVNULL) as running:
            while not os.path.exists(child + "True") and running.poll() is None:
                time.sleep(0.02)
            running.terminate()
            self.assertEqual(running.wait(), 130)
        with open(child + "True", encoding="ascii") as file:
            self.assertTrue(gone(int(file.read())))
        self.assertLess(len(read_off(os.path.join(keep, "pose_1.off"))[0].faces), len(kinds.make("pose", 1).surface.faces))

    def test_usage(self):
        path = program(self.folder, "sys.exit(4)")
        self.assertEqual(self.stress("--help")[0], 0)
        for wrong in (["--seeds", "x"], ["--seeds", "3-1"], ["--kinds", "none"], ["--minimise"], ["--time", "0"],
                      ["--again", "nowhere.off"]):
            code, said, why = self.stress("--program", path, *wrong)
            self.assertEqual((code, said), (2, ""), wrong)
            self.assertNotIn("Traceback", why)
        self.assertEqual(self.stress("--program", "nowhere")[0], 2)

    def test_only_written(self):
        code, said, _ = self.stress("--write", "here", "--kinds", "bend", "cake", "--seeds", "5")
        self.assertEqual((code, said.split()), (0, ["here/bend_5.off", "here/cake_5.off"]))
        surface, _ = read_off(os.path.join(self.folder, "here", "bend_5.off"))
        self.assertEqual(off_text(surface), off_text(kinds.make("bend", 5).surface))


if __name__ == "__main__":
    unittest.main()
