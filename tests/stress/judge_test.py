"""The judge: what it accepts of a program, and what it does not."""

import json
import os
import tempfile
import unittest

import support
from hard_models import judge, kinds
from hard_models.judge import Judge
from hard_models.kinds import Model
from hard_models.mesh_check import mesh_faults
from hard_models.mesh_file import mesh_text, read_mesh
from hard_models.surface import flipped
from support import bar, program, with_middle


class Meshes(unittest.TestCase):
    """mesh_faults() accepts a mesh, and nothing that is almost one."""

    def setUp(self):
        self.solid = with_middle(bar(2))
        self.surface = self.solid.surface
        self.points = [tuple(map(float, p)) for p in self.solid.points]
        self.tets = self.solid.tets

    def faults(self, points=None, tets=None, moved=None):
        return mesh_faults(self.surface, points or self.points, tets or self.tets, moved)

    def test_accepted(self):
        self.assertEqual(self.faults(), "")

    def test_solids_are_meshes_of_their_surfaces(self):
        for kind in kinds.BUILT:
            solid = kinds.make(kind, 1).solid
            self.assertEqual(mesh_faults(solid.surface, solid.points, solid.tets), "", kind)

    def test_flipped_tet(self):
        for i, (a, b, c, d) in enumerate(self.tets):
            self.assertNotEqual(self.faults(tets=[*self.tets[:i], (b, a, c, d), *self.tets[i + 1 :]]), "")
        outside = [*self.points[:-1], tuple(x + 500 for x in self.points[-1])]  # the inner vertex
        self.assertIn("not positive", self.faults(points=outside))

    def test_moved_vertex(self):
        for change in (1e-13, 5e-324, -1.0):
            moved = [(self.points[0][0] + change, *self.points[0][1:]), *self.points[1:]]
            if moved == self.points:
                continue
            self.assertEqual(self.faults(points=moved), "vertex 0 has moved")
        minus = [tuple(-0.0 if x == 0 else x for x in p) for p in self.points]
        self.assertIn("has moved", self.faults(points=minus))
        moved = [tuple(x + 0.25 for x in self.points[0]), *self.points[1:]]
        self.assertEqual(self.faults(points=moved, moved={0}), "")
        self.assertEqual(self.faults(points=moved, moved={1}), "vertex 0 has moved")

    def test_missing_boundary_face(self):
        self.assertIn("boundary face", self.faults(tets=self.tets[:-1]))
        self.assertIn("boundary face", mesh_faults(flipped(self.surface), self.points, self.tets))

    def test_missing_vertex_and_extra_ones(self):
        self.assertIn("vertices", mesh_faults(self.surface, self.points[:3], self.tets))
        self.assertIn("does not exist", self.faults(tets=[*self.tets, (0, 1, 2, 999)]))
        self.assertIn("no tet", self.faults(points=[*self.points, (0.5, 0.5, 0.5)]))

    def test_files(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "m.mesh")
            points = [(0.1, 1 / 3, -1e-300), *self.points[1:]]
            with open(path, "w", encoding="ascii") as file:
                file.write(mesh_text(points, self.tets))
            self.assertEqual(read_mesh(path), (points, self.tets))
            for text in ("", "Vertices 2 0 0 0 0 1 1", "Vertices\n1\n0 0 0 0\n"):
                with open(path, "w", encoding="ascii") as file:
                    file.write(text)
                self.assertRaises(judge.Unreadable, read_mesh, path)


class Answers(unittest.TestCase):
    """Programs that are made up: what the judge calls what they do."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.solid = with_middle(bar(1))
        self.built, self.other = Model(self.solid.surface, self.solid), Model(self.solid.surface)

    def verdict(self, body, model=None, **options):
        v = Judge(program(self.folder, body), **{"limit": 20, **options})(model or self.built)
        return v.what, v.failed

    def writes(self, points, tets):
        return f"if command == 'mesh':\n    open(output, 'w').write({mesh_text(points, tets)!r})\n"

    def reports(self, **report):
        return f"json.dump({dict(report, status='infeasible')!r}, open(report, 'w'))\n"

    def test_meshes(self):
        points, tets = self.solid.points, self.solid.tets
        self.assertEqual(self.verdict(self.writes(points, tets)), (judge.MESH, False))
        self.assertEqual(self.verdict(self.writes(points, tets) + "sys.exit(0 if command == 'mesh' else 4)"),
                         (judge.REFUSED_MESH, True))
        self.assertEqual(self.verdict(self.writes(points, tets[1:])), (judge.WRONG_MESH, True))
        moved = [(0.5, *points[0][1:]), *points[1:]]
        self.assertEqual(self.verdict(self.writes(moved, tets)), (judge.WRONG_MESH, True))
        self.assertEqual(self.verdict("pass"), (judge.WRONG_MESH, True))

    def test_exit_codes(self):
        self.assertEqual(self.verdict("sys.exit(4)"), (judge.UNSOLVED, True))
        self.assertEqual(self.verdict("sys.exit(4)", self.other), (judge.UNSOLVED, False))
        self.assertEqual(self.verdict("sys.exit(3)", self.other), (judge.BAD_INPUT, True))
        self.assertEqual(self.verdict("sys.exit(70)", self.other), (judge.CRASH, True))
        self.assertEqual(self.verdict("os.kill(os.getpid(), 11)", self.other), (judge.CRASH, True))
        self.assertEqual(self.verdict("sys.exit(6)", self.other), (judge.BAD_EXIT, True))
        self.assertEqual(self.verdict("time.sleep(60)", self.other, limit=0.1), (judge.NO_ANSWER, True))
        self.assertEqual(self.verdict("while True: pass", self.other, limit=0.3), (judge.NO_ANSWER, True))
        self.assertEqual(self.verdict("time.sleep(1)\nsys.exit(4)", self.other, limit=0.3), (judge.UNSOLVED, False))

    def test_witnesses(self):
        wrong = self.reports(witness={"rule": "winding", "point": [5, 5, 5], "winding": -1}) + "sys.exit(5)"
        self.assertEqual(self.verdict(wrong, self.other), (judge.REFUTED, True))
        self.assertEqual(self.verdict(wrong), (judge.FALSE_WITNESS, True))
        self.assertEqual(self.verdict("sys.exit(5)", self.other), (judge.REFUTED, True))
        inverse = Model(flipped(self.solid.surface))
        right = self.reports(witness={"rule": "winding", "point": [5.5, 5.25, 5.125], "winding": -1}) + "sys.exit(5)"
        self.assertEqual(self.verdict(right, inverse), (judge.INFEASIBLE, False))

    def test_repairs(self):
        """Of a cube that stands inside out: a made-up program meshes another one."""
        inverse = Model(flipped(self.solid.surface))
        witness = self.reports(witness={"rule": "winding", "point": [5.5, 5.25, 5.125], "winding": -1})
        start = f"if command == 'mesh' and 'repair' not in sys.argv:\n    {witness}    sys.exit(5)\n"
        self.assertEqual(self.verdict(start + "sys.exit(4)", inverse, repair=True), (judge.INFEASIBLE, False))
        self.assertEqual(self.verdict(start + "sys.exit(70)", inverse, repair=True), (judge.CRASH, True))
        # Mirrored, so that the flipped faces face outwards.
        points = [(-p[0], *p[1:]) for p in self.solid.points]
        tets = [(b, a, c, d) for a, b, c, d in self.solid.tets]
        ids = list(range(len(points)))
        for moved, expected in ((ids, (judge.REPAIRED, False)), (ids[:5], (judge.WRONG_REPAIR, True))):
            report = {"moved": {"ids": moved, "max_relative": 0.1}}
            body = (start + "if command == 'mesh':\n" + f"    json.dump({json.dumps(report)}, open(report, 'w'))\n"
                    + f"    open(output, 'w').write({mesh_text(points, tets)!r})\n")
            self.assertEqual(self.verdict(body, inverse, repair=True), expected)
        self.assertEqual(self.verdict(start + "pass", inverse, repair=True), (judge.WRONG_REPAIR, True))


if __name__ == "__main__":
    unittest.main()
