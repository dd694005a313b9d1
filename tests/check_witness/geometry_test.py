"""Files, winding numbers, B0 against its definition by angles, levels of edges, links."""

import collections
import random
import unittest
from fractions import Fraction

import support
from angles import angle_b0
from support import TET_FACES, TET_POINTS, flipped, joined, random_cone, surface_of
from witness_checker.errors import Grazed, Refuted, Unreadable
from witness_checker.geometry.cover import Disc
from witness_checker.geometry.edges import levels
from witness_checker.geometry.euler import b0_by_counting, turns_needed
from witness_checker.geometry.link import Link
from witness_checker.geometry.parts import Parts
from witness_checker.geometry.ring import link_crosses_itself, link_of, ring_of
from witness_checker.geometry.surface import Surface
from witness_checker.geometry.turns import b0, turns_past_east
from witness_checker.geometry.winding import DIRECTIONS, ahead, winding
from witness_checker.sets import Sets

SEED = 1


class Surfaces(unittest.TestCase):
    def test_integers_are_the_doubles(self):
        s = surface_of(([(0.1, -1e-30, 3.0), *TET_POINTS[1:]], TET_FACES))
        self.assertEqual([Fraction(x, s.scale) for x in s.points[0]], [Fraction(0.1), Fraction(-1e-30), 3])

    def test_what_is_no_closed_oriented_surface(self):
        for faces in (TET_FACES[:3], TET_FACES + TET_FACES[:1], flipped(TET_FACES[:1]) + TET_FACES[1:], [(0, 0, 1)]):
            with self.assertRaises(Unreadable):
                Surface(TET_POINTS, faces)

    def test_component(self):
        s = surface_of(joined((TET_POINTS, TET_FACES), (TET_POINTS, TET_FACES)))
        one = s.component(5, (1, 2, 3))
        self.assertEqual((len(one.faces), len(one.rest.faces), one.points), (4, 4, s.points))
        with self.assertRaises(Refuted):
            surface_of((TET_POINTS, TET_FACES)).component(0, (1, 2, 3))


class WindingNumbers(unittest.TestCase):
    def test_nested(self):
        models = [([tuple(size * (x - 0.25) for x in p) for p in TET_POINTS], TET_FACES) for size in (1, 2, 4)]
        s = surface_of(joined(*models))
        for x, expected in ((0, 3), (Fraction(-3, 8), 2), (Fraction(-3, 4), 1), (-2, 0)):
            x = Fraction(x) * s.scale
            q = (int(x * 8), int(x * 8), int(x * 8))
            self.assertEqual(winding(s, q, 8)[0], expected)
            for d in DIRECTIONS:
                try:
                    self.assertEqual(ahead(s, q, 8, d), expected)
                except Grazed:
                    pass

    def test_on_the_surface(self):
        s = surface_of((TET_POINTS, TET_FACES))
        with self.assertRaises(Refuted):
            winding(s, (1, 1, 0), 4)
        f = next(f for f, c in enumerate(TET_FACES) if 3 not in c)
        value, d = winding(s, (1, 1, 0), 4, {f})
        self.assertEqual(value, int(d[2] > 0))


class Integers(unittest.TestCase):
    """B0 from signs is B0 from areas and angles."""

    def test_random_links(self):
        print(f"seeds from {SEED}")
        seen = collections.Counter()
        for seed in range(SEED, SEED + 500):
            rng = random.Random(seed)
            model = random_cone(seed, (3, 9), rng.choice((2, 5, 40)))
            try:
                b0(surface_of(model), 0)
                disc = Disc(surface_of(model), 0)
            except (Refuted, Unreadable):
                continue
            with self.subTest(seed=seed):
                value = angle_b0(disc.out, disc.link, disc.w)
                self.assertEqual(b0(surface_of(model), 0, disc.layers), value)
                self.assertEqual(turns_needed(disc.link, disc.w), value)
                self.assertEqual(b0_by_counting(surface_of(model), 0), b0(surface_of(model), 0))
                seen[value] += 1
                extra = {cell: layers + 2 for cell, layers in disc.w.items()}
                self.assertEqual(angle_b0(disc.out, disc.link, extra), value + 4)
        self.assertGreater(len(seen), 2)

    def test_all_directions_agree(self):
        """Also for links with folds, corners on arcs, and arcs on each other."""
        looked = 0
        for seed in range(SEED, SEED + 300):
            s = surface_of(random_cone(seed, (3, 7), 2))
            out = link_of(s, 0)
            values = set()
            for d in [*DIRECTIONS, *(tuple(-x for x in d) for d in DIRECTIONS)]:
                try:
                    both = [ahead(s, s.points[0], 1, x, set(s.at_vertex[0])) for x in (d, tuple(-x for x in d))]
                    values.add(turns_past_east(out, d) + sum(both))
                except (Grazed, Refuted):
                    continue
            with self.subTest(seed=seed):
                self.assertLessEqual(len(values), 1)
            looked += len(values)
        self.assertGreater(looked, 100)

    def test_simple_corners(self):
        for v in range(4):
            self.assertEqual(b0(surface_of((TET_POINTS, TET_FACES)), v), 0)
            self.assertEqual(b0(surface_of((TET_POINTS, flipped(TET_FACES))), v), -2)

    def flap(self, height):
        """Around vertex 0; the faces on both sides of edge 0-2 lie on each other where the height is 0."""
        points = [(0.0, 0.0, 0.0), (4.0, -2.0, height), (1.0, 3.0, 0.0), (4.0, 2.0, 0.0), (-3.0, 1.0, 2.0)]
        points.append((1.0, 1.0, 9.0))
        ring = [1, 2, 3, 4]
        faces = [(0, ring[k - 1], ring[k]) for k in range(4)] + [(5, ring[k], ring[k - 1]) for k in range(4)]
        return surface_of((points, faces))

    def test_a_fold_is_a_full_turn(self):
        """B0 is that of the limit from almost a full turn inside, and one less than that from almost none."""
        values = []
        for height in (-(2.0**-20), 2.0**-20):
            s = self.flap(height)
            values.append(b0(s, 0))
            self.assertEqual(values[-1], self.by_hand(s))
        self.assertEqual(max(values) - min(values), 1)
        self.assertEqual(b0(self.flap(0.0), 0), min(values))

    def by_hand(self, s):
        link = Link(link_of(s, 0))
        level = next(levels(s, 0, ring_of(s, 0)[0]))
        return angle_b0(link.out, link, link.count_layers(link.outside(0), level))

    def test_faces_without_area(self):
        points = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
        with self.assertRaises(Unreadable):
            b0(surface_of((points, TET_FACES)), 0)


class Edges(unittest.TestCase):
    def test_levels(self):
        s = surface_of((TET_POINTS, TET_FACES))
        self.assertEqual(list(levels(s, 0, 1)), [0])
        half = [(x - 0.5, y - 0.2, z - 0.2) for x, y, z in TET_POINTS]
        both = surface_of(joined((TET_POINTS, TET_FACES), (half, TET_FACES)))
        found = list(levels(both, 0, 1))
        self.assertEqual((found[0], found[-1]), (1, 0))
        self.assertEqual(list(levels(both, 1, 0)), found[::-1])


class Links(unittest.TestCase):
    def test_which_cross_themselves(self):
        self.assertFalse(link_crosses_itself(surface_of((TET_POINTS, TET_FACES)), 0))
        seen = set()
        for seed in range(SEED, SEED + 100):
            s = surface_of(random_cone(seed, (4, 7)))
            try:
                crossed = bool(Link(link_of(s, 0)).crossings)
            except Refuted:
                continue
            with self.subTest(seed=seed):
                self.assertEqual(link_crosses_itself(s, 0), crossed)
            seen.add(crossed)
        self.assertEqual(len(seen), 2)

    def test_cells(self):
        """A connected link: nodes less pieces and cells are 2; every crossing is one of two arcs."""
        for seed in range(SEED, SEED + 200):
            link = support.random_link(seed, (3, 8))
            if link is None:
                continue
            with self.subTest(seed=seed):
                self.assertEqual(len(link.at) - len(link.pieces) + link.cells, 2)
                self.assertEqual(len(link.pieces), link.corners + 2 * len(link.crossings))
                self.assertEqual(min(link.least_layers().values()), 0)

    def test_folds_and_touching_arcs_are_refused(self):
        for out in (
            [(1, 0, 0), (0, 1, 0), (2, 1, 0), (0, 0, 1)],
            [(1, 0, 0), (0, 1, 0), (-1, 0, 1), (1, 1, 0), (0, 0, 1)],
        ):
            with self.assertRaises(Refuted):
                Link(out)


class PartsOfFaces(unittest.TestCase):
    def test_two_tets(self):
        moved = [(x + 0.25, y + 0.1875, z + 0.125) for x, y, z in TET_POINTS]
        s = surface_of(joined((TET_POINTS, TET_FACES), (moved, TET_FACES)))
        parts = Parts(s)
        border = collections.Counter(piece[0] for piece in parts.after)
        self.assertEqual(set(border), set(range(8)))
        # Each piece of curve has parts on both sides in both faces.
        for f, g, p, q in parts.pieces:
            self.assertEqual(len({parts.left[h, x, y] for h in (f, g) for x, y in ((p, q), (q, p))}), 4)
        self.assertGreater(len(parts.face_of), 8)

    def test_touching_is_refused(self):
        moved = [(x + 0.25, y + 0.25, z) for x, y, z in TET_POINTS]
        with self.assertRaises(Refuted):
            Parts(surface_of(joined((TET_POINTS, TET_FACES), (moved, TET_FACES))))


class UnionFind(unittest.TestCase):
    def test_sets(self):
        sets = Sets()
        for x, y in ((1, 2), (3, 4), (2, 3)):
            sets.join(x, y)
        self.assertEqual(len({sets.root(x) for x in (1, 2, 3, 4)}), 1)
        self.assertNotEqual(sets.root(1), sets.root(5))


if __name__ == "__main__":
    unittest.main()
