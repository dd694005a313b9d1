"""Every rule confirms a right witness, and refuses altered ones and surfaces that it does not fit."""

import copy
import unittest

import support
from support import TET_FACES, TET_POINTS, flipped, joined, random_cone, surface_of
from witness_checker.errors import Refuted, Unreadable
from witness_checker.geometry.parts import Parts
from witness_checker.geometry.shells import Shells
from witness_checker.geometry.turns import b0
from witness_checker.report import RULES, rule_of
from witness_checker.rules.shared import room_at

TET = (TET_POINTS, TET_FACES)
INSIDE_OUT = (TET_POINTS, flipped(TET_FACES))


class Rule(unittest.TestCase):
    def check(self, model, witness):
        """A model is (points, faces)."""
        return RULES[rule_of(witness)].check(surface_of(model), witness)

    def confirms(self, model, witness):
        self.assertTrue(self.check(model, witness))

    def refuses(self, model, witness, error=Refuted, **altered):
        with self.assertRaises(error):
            self.check(model, {**copy.deepcopy(witness), **altered})


class Area(Rule):
    def test_corners_on_one_line(self):
        points = [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
        right = {"rule": "area", "face": TET_FACES.index(next(f for f in TET_FACES if 3 not in f)), "vertices": [0, 1, 2]}
        self.confirms((points, TET_FACES), right)
        self.refuses(TET, right)
        self.refuses((points, TET_FACES), right, vertices=[0, 1, 3])
        self.refuses((points, TET_FACES), right, Unreadable, face=4)
        self.refuses((points, TET_FACES), right, Unreadable, vertices="x")


class Winding(Rule):
    def test_inside_out(self):
        right = {"rule": "winding", "point": [0.125, "1/7", 0.25], "winding": -1}
        self.confirms(INSIDE_OUT, right)
        self.refuses(TET, right)
        self.refuses(INSIDE_OUT, right, winding=-2)
        self.refuses(INSIDE_OUT, right, point=[1, 1, 1])
        self.refuses(INSIDE_OUT, right, point=[0.25, 0.25, 0])  # on a face
        for point in ([1, 2], [1, 2, "x"], [1, 2, None], 3):
            self.refuses(INSIDE_OUT, right, Unreadable, point=point)
        self.refuses(INSIDE_OUT, right, Unreadable, winding="x")

    def test_far_and_tiny(self):
        for size in (2.0**-1000, 2.0**-300, 2.0**300, 2.0**1000):
            points = [tuple(x * size for x in p) for p in TET_POINTS]
            right = {"point": [size / 8, size / 8, size / 8], "winding": -1}
            self.confirms((points, flipped(TET_FACES)), right)
            self.refuses((points, TET_FACES), right)


class VertexAndFold(Rule):
    def test_negative(self):
        for rule in ({}, {"rule": "fold"}):
            for seed, value in ((1, -1), (5, -2), (4, -3), (68, -4)):
                right = {**rule, "vertices": [0], "B0": [value]} if rule else {"vertex": 0, "B0": value}
                key, wrong = ("B0", [value - 1]) if rule else ("B0", value - 1)
                with self.subTest(seed=seed, witness=right):
                    self.confirms(random_cone(seed), right)
                    self.refuses(random_cone(seed), right, **{key: wrong})
                    self.refuses(TET, right)
        self.refuses(random_cone(40), {"vertex": 0, "B0": 1})
        self.refuses(TET, {"vertex": 0, "B0": 0})
        for vertex in (100, -1, "0", True, None):
            self.refuses(TET, {"vertex": vertex, "B0": -1}, Unreadable)
        self.refuses(TET, {"rule": "fold", "vertices": [0, 1], "B0": [0, 0]}, Unreadable)


class Hinges(Rule):
    def test_unpaired(self):
        for seed in (17, 40, 60):
            right = {"rule": "unpaired", "vertices": [0], "B0": [1]}
            with self.subTest(seed=seed):
                self.confirms(random_cone(seed), right)
                self.refuses(random_cone(seed), right, B0=[3])
                self.refuses(random_cone(seed), right, B0=[-1])
                self.refuses(random_cone(seed), right, Unreadable, B0=[1, 1])
                self.refuses(random_cone(seed), right, Unreadable, vertices=[0, 0], B0=[1, 1])
        self.refuses(TET, {"rule": "unpaired", "vertices": [0], "B0": [0]})  # even
        self.refuses(random_cone(220), {"rule": "unpaired", "vertices": [0], "B0": [2]})

    def test_covered_edges_join(self):
        """Inside of another component all edges are covered, and another odd vertex is found."""
        cone = random_cone(17)
        around = ([tuple(1000 * (x - 0.25) for x in p) for p in TET_POINTS], TET_FACES)
        self.refuses(joined(cone, around), {"rule": "crowded", "vertices": [0], "B0": [1]})

    def test_apart(self):
        cone = random_cone(40)
        both = joined(cone, cone)
        alone = {"rule": "unpaired", "vertices": [0], "B0": [1]}
        self.refuses(both, alone)
        found = []
        for away in ([101, 37, 53], [-101, -37, -53]):
            try:
                found.append(bool(self.check(both, {**alone, "apart": away})))
            except Refuted:
                found.append(False)
        self.assertIn(True, found)
        away = [101, 37, 53] if found[0] else [-101, -37, -53]
        self.refuses(both, alone, apart=away, B0=[3])
        self.refuses(cone, alone, apart=away)  # nothing to move from
        self.refuses(both, alone, Unreadable, apart=[1, 2, 0])
        self.refuses(both, alone, Unreadable, apart=[1, 2.5, 3])

    def test_crowded_and_link(self):
        for rule in ("crowded", "link"):
            for seed, value in ((40, 1), (64, 1), (352, 1), (220, 2), (543, 2)):
                right = {"rule": rule, "vertices": [0], "B0": [value]}
                with self.subTest(rule=rule, seed=seed):
                    self.confirms(random_cone(seed), right)
                    self.refuses(random_cone(seed), right, B0=[value + 2])
                    self.refuses(random_cone(seed), right, B0=[0])
                    self.refuses(random_cone(seed), right, Unreadable, vertices=[0, 1], B0=[value, 0])
                    self.refuses(random_cone(seed), right, vertices=[2])
            self.refuses(TET, {"rule": rule, "vertices": [0], "B0": [0]})  # simple corners are filled


class Shared(Rule):
    def test_copies(self):
        cone = random_cone(40)
        n = len(cone[0])
        both = joined(cone, cone)
        surface = surface_of(both)
        room = room_at(surface, surface.points[0], 1, True)
        right = {"rule": "shared", "vertices": [0, n], "layers": [1, 1], "room": room}
        self.confirms(both, right)
        self.refuses(both, right, room=room + 1)
        self.refuses(both, right, layers=[0, 0])
        self.refuses(both, right, vertices=[0, n + 1])
        self.refuses(both, right, vertices=[0, 0])
        self.refuses(both, right, Unreadable, layers=[1])
        self.refuses(both, right, Unreadable, layers=[-1, 1])
        around = ([tuple(1000 * (x - 0.25) for x in p) for p in TET_POINTS], TET_FACES)
        self.assertEqual(room, 0)
        self.refuses(joined(both, around), right)
        self.confirms(joined(both, around), right | {"room": 1})  # the winding number is negative beside an edge
        self.refuses(joined(both, around, around), right | {"room": 2})


class Stack(Rule):
    def test_end_that_is_pushed_out(self):
        """A tet inside out, inside of another one, on its face: when pushed through it, nothing is around it."""
        inner = [(0.25, 0.25, 0.0), (0.5, 0.25, 0.0), (0.25, 0.5, 0.0), (0.25, 0.25, 0.25)]
        both = joined((TET_POINTS, TET_FACES), (inner, flipped(TET_FACES)))
        face = next(f for f, c in enumerate(both[1]) if f >= 4 and all(both[0][v][2] == 0 for v in c))
        # Its normal leads inside: the moves are against it.
        right = {"rule": "stack", "face": face, "place": ["1/3", 0.3, 0], "vertices": [4, 5, 6], "moves": [-1, -1, -1]}
        right["winding"] = -1
        self.confirms(both, right)
        self.refuses(both, right, moves=[1, 1, 1])
        self.refuses(both, right, moves=[0, 0, 0])
        self.refuses(both, right, winding=-2)
        self.refuses(both, right, place=[0.25, 0.25, 0])  # a corner
        self.refuses(both, right, place=[0.3, 0.3, 0.5])  # on no face
        self.refuses(both, right, Unreadable, moves=[1])
        self.refuses(both, right, Unreadable, face=99)


class Gluing(Rule):
    def everything(self, model):
        """A witness that names all curves and edges."""
        shells = Shells(Parts(surface_of(model)), set())
        curves = {(f, g, shells.layers(four[0], 0)) for (f, g, _, _), four in zip(shells.parts.pieces, shells.around)}
        return [("curve", *x) for x in sorted(curves)] + [("edge", *x) for x in sorted(shells.cover)]

    def witness(self, named):
        curves = [x[1:] for x in named if x[0] == "curve"]
        return {
            "rule": "gluing",
            "pairs": [list(x[:2]) for x in curves],
            "layers": [x[2] for x in curves],
            "edges": [list(x[1:]) for x in named if x[0] == "edge"],
        }

    def holds(self, model, named):
        try:
            return bool(self.check(model, self.witness(named)))
        except Refuted:
            return False

    def test_contradictions(self):
        for seed in (64, 352, 543):
            model = random_cone(seed)
            named = self.everything(model)
            with self.subTest(seed=seed):
                self.assertTrue(self.holds(model, named))
                for x in list(named):  # what is left without anything that is not needed
                    rest = [y for y in named if y != x]
                    named = rest if self.holds(model, rest) else named
                self.assertTrue(self.holds(model, named))
                self.assertFalse(any(self.holds(model, [y for y in named if y != x]) for x in named))
                other = self.witness(named)
                other["layers"] = [m + 7 for m in other["layers"]]
                self.refuses(model, other)
                self.refuses(TET, self.witness(named))
                self.refuses(model, self.witness(named), Unreadable, layers=[])
                self.refuses(model, self.witness(named), Unreadable, pairs=[[1]])
                self.refuses(model, self.witness(named), Unreadable, edges=[[1, "a"]])

    def test_what_can_be_glued(self):
        for seed in (147, 972):
            model = random_cone(seed)
            self.assertFalse(self.holds(model, self.everything(model)))
        self.assertEqual(b0(surface_of(random_cone(147)), 0), 1)  # a hinge all the same


if __name__ == "__main__":
    unittest.main()
