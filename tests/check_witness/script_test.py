"""scripts/check_witness as a program: exit codes, what it prints, and that it leaves no files behind."""

import os
import subprocess
import tempfile
import unittest

import support
from support import TET_FACES, TET_POINTS, answer, flipped, joined, random_cone

INSIDE_OUT = (TET_POINTS, flipped(TET_FACES))
POINT = {"rule": "winding", "point": [0.125, 0.125, 0.125], "winding": -1}
CROWDED = random_cone(64)  # its winding number is nowhere negative, so that the solver is asked


def link_witness(value=1):
    return {"rule": "link", "vertices": [0], "B0": [value]}


class Script(unittest.TestCase):
    def test_exit_codes(self):
        code, said = answer(INSIDE_OUT, POINT)
        self.assertEqual((code, said), (0, "Confirmed: the surface winds around the point -1 times.\n"))
        code, said = answer((TET_POINTS, TET_FACES), POINT)
        self.assertEqual((code, said), (1, "Refuted: the winding number of the point is 1.\n"))
        code, said = answer(INSIDE_OUT, {"rule": "unheard of"})
        self.assertEqual((code, said.split(":")[0]), (2, "Unreadable"))
        self.assertEqual(answer(INSIDE_OUT, {**POINT, "point": [1, 2]})[0], 2)
        self.assertEqual(answer(CROWDED, {**link_witness(), "apart": [1, 2, 3]})[0], 2)

    def test_solver_decides(self):
        self.assertEqual(answer(CROWDED, link_witness())[0], 0)
        self.assertEqual(answer(CROWDED, link_witness(3))[0], 1)
        around = ([tuple(1000 * (x - 0.25) for x in p) for p in TET_POINTS], TET_FACES)
        code, said = answer(joined(CROWDED, around), link_witness(3))
        self.assertEqual((code, "bounds a disc" in said), (1, True), said)

    def test_without_the_solver_nothing_is_confirmed(self):
        with tempfile.TemporaryDirectory() as folder:
            nothing = {"PATH": folder}
            code, said = answer(CROWDED, link_witness(), nothing)
            self.assertEqual((code, said.split(":")[0], "not installed" in said), (3, "Undecided", True), said)
            self.assertEqual(answer(INSIDE_OUT, POINT, nothing)[0], 0)  # rules that need none
            with open(os.path.join(folder, "cadical"), "w", encoding="ascii") as file:
                file.write("#!/bin/sh\nexit 20\n")
            os.chmod(os.path.join(folder, "cadical"), 0o755)
            code, said = answer(CROWDED, link_witness(), nothing)
            self.assertEqual((code, "proof" in said), (3, True), said)

    def test_usage(self):
        for arguments in ([], ["-h"], ["--help"], ["a"], ["a", "b", "c"]):
            done = subprocess.run([support.SCRIPT, *arguments], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertIn("Usage: check_witness SURFACE REPORT.json", done.stderr)
            self.assertIn("What is exact", done.stderr)

    def test_from_anywhere(self):
        """Through a link, from another folder; and no files are left."""
        before = self.files()
        with tempfile.TemporaryDirectory() as folder:
            os.symlink(support.SCRIPT, os.path.join(folder, "check"))
            done = subprocess.run(["./check", "a", "b"], cwd=folder, capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stderr.split(":")[0]), (2, "Unreadable"))
        self.assertEqual(self.files(), before)

    def files(self):
        return sorted(os.path.join(a, x) for a, _, names in os.walk(os.path.join(support.ROOT, "scripts")) for x in names)


if __name__ == "__main__":
    unittest.main()
