"""The models: closed oriented manifolds, solids where they are built from tets, the same ones from the same numbers."""

import math
import random
import unittest

import support  # noqa: F401
from hard_models import kinds
from hard_models.complex import faults as solid_faults
from hard_models.complex import parts_of_edges, turns_of
from hard_models.collapse import collapse_to
from hard_models.exact import integers, turns, volume
from hard_models.growth import Growth, grow, one_tet, shake, spin, weld
from hard_models.kinds import shapes
from hard_models.seeds import source_of
from hard_models.surface import Surface, faults, flipped, joined, off_text
from support import bar, spiral, with_middle

NUMBERS = range(1, 5)


def volume_of(surface):
    """Enclosed, six times."""
    points = integers(surface.points)
    return sum(volume((0, 0, 0), *(points[v] for v in f)) for f in surface.faces)


class Models(unittest.TestCase):
    def test_surfaces_are_closed_oriented_manifolds(self):
        for kind in kinds.ALL:
            for n in NUMBERS:
                surface = kinds.make(kind, n).surface
                self.assertEqual(faults(surface), "", (kind, n))
                self.assertTrue(all(math.isfinite(x) for p in surface.points for x in p), (kind, n))

    def test_solids(self):
        for kind in kinds.BUILT:
            for n in NUMBERS:
                model = kinds.make(kind, n)
                self.assertEqual(model.solid.faults(), "", (kind, n))
                self.assertTrue(model.has_mesh)
                self.assertEqual(model.surface.points, model.solid.points[: len(model.surface.points)])
                self.assertEqual(volume_of(model.surface), sum(volume(*(model.solid.points[v] for v in t))
                                                               for t in model.solid.tets), (kind, n))
        for kind in kinds.DEFORMED:
            self.assertFalse(kinds.make(kind, 1).has_mesh)

    def test_same_number_same_bytes(self):
        for kind in kinds.ALL:
            one, again, other = (off_text(kinds.make(kind, n).surface) for n in (3, 3, 4))
            self.assertEqual(one, again, kind)
            self.assertNotEqual(one, other, kind)

    def test_shapes_face_outwards(self):
        for shape in (*shapes.ALL, lambda _: shapes.creature({0: 3, 1: 2, 2: 2, 5: 4}, 2)):
            for n in range(10):
                surface = shape(random.Random(n))
                self.assertEqual(faults(surface), "")
                self.assertEqual(len(surface.components()), 1)
                self.assertGreater(volume_of(surface), 0)

    def test_some_edges_are_wound(self):
        """More than a turn, around edges of the boundary."""
        for kind in ("fan", "blocks"):
            wound = 0
            for n in NUMBERS:
                solid = kinds.make(kind, n).solid
                for (a, b), pairs in parts_of_edges(solid.tets).items():
                    p, q = (solid.points[v] for v in (a, b))
                    around = sum(volume(p, q, solid.points[x], solid.points[pairs[0][0]]) >= 0 >
                                 volume(p, q, solid.points[y], solid.points[pairs[0][0]]) for x, y in pairs)
                    wound += around > 1
            self.assertGreater(wound, 0, kind)


class Surfaces(unittest.TestCase):
    def test_faults(self):
        s = bar(1).surface
        self.assertEqual(faults(s), "")
        self.assertIn("has one face", faults(Surface(s.points, s.faces[1:])))
        self.assertIn("two faces", faults(Surface(s.points, [*s.faces, s.faces[0]])))
        self.assertIn("has no face", faults(Surface([*s.points, (0, 0, 0)], s.faces)))
        one, n = s.faces, len(s.points)
        glued = [tuple(0 if v == n else v for v in f) for f in joined(s, s).faces]
        self.assertIn("more than one fan", faults(Surface(joined(s, s).points, glued).only(glued)))
        a, b, c = one[0]
        self.assertIn("two faces", faults(Surface(s.points, [(a, c, b), *one[1:]])))

    def test_components(self):
        s = bar(2).surface
        self.assertEqual([len(c) for c in joined(s, s, flipped(s)).components()], 3 * [len(s.faces)])

    def test_collapses_leave_manifolds(self):
        for n in range(1, 5):
            s = kinds.make("pose", n).surface
            for faces in (4, 20, 100):
                small = collapse_to(s, faces)
                self.assertEqual(faults(small), "")
                self.assertLess(len(small.faces), len(s.faces))


class Solids(unittest.TestCase):
    def test_turns_against_angles(self):
        rng = random.Random(5)
        for _ in range(200):
            steps = [rng.uniform(0.3, 3) for _ in range(rng.randint(3, 12))]
            whole = max(1, round(sum(steps) / (2 * math.pi)))
            steps = [x * whole * 2 * math.pi / sum(steps) for x in steps]
            if max(steps) > 3:
                continue
            angles = [sum(steps[:i]) for i in range(len(steps))]
            radii = [rng.randint(100, 10000) for _ in steps]
            ring = [(round(r * math.cos(a)), round(r * math.sin(a)), rng.randint(-99, 99)) for r, a in zip(radii, angles)]
            self.assertEqual(turns((0, 0, 0), (0, 0, 7), ring), whole)

    def test_faults(self):
        good = with_middle(bar(2))
        self.assertEqual(good.faults(), "")
        a, b, c, d = good.tets[3]
        self.assertIn("not positive", solid_faults(good.points, [*good.tets[:3], (b, a, c, d), *good.tets[4:]]))
        self.assertIn("same side", solid_faults(good.points, [*good.tets, good.tets[0]]))
        self.assertNotEqual(solid_faults(good.points, good.tets[:3] + good.tets[5:]), "")
        far = [(1000 + x, y, z) for x, y, z in good.points]
        both = [tuple(v + len(far) for v in t) for t in good.tets]
        self.assertEqual(solid_faults(good.points + far, good.tets + both), "")
        pinched = [tuple(0 if v == len(far) else v for v in t) for t in both]
        moved = [tuple(x - y + z for x, y, z in zip(p, far[0], good.points[0])) for p in far]
        used = good.points + moved[1:]
        pinched = [tuple(v - (v > 0 and v >= len(far)) for v in t) for t in pinched]
        self.assertIn("no ball", solid_faults(used, good.tets + pinched))

    def test_two_turns_are_a_fault(self):
        """Eight cubes around an edge, the last glued to the first: all tets are positive, but they form a branch line."""
        self.assertEqual(spiral(8).faults(), "")
        self.assertIn("make 2 turns", solid_faults(*with_ends_glued(spiral(8), 8)))
        self.assertEqual(solid_faults(*with_ends_glued(spiral(4), 4)), "")

    def test_growth_stays_a_solid(self):
        ways = {"into_edge": 0, "tunnel": 0}

        class Counting(Growth):
            def into_edge(self, *a):
                done = super().into_edge(*a)
                ways["into_edge"] += done
                return done

            def tunnel(self, *a):
                done = super().tunnel(*a)
                ways["tunnel"] += done
                return done

        for n in range(12):
            rng = source_of("test", n)
            first = one_tet(rng, 100)
            growth = Counting(first.points, first.tets)
            grow(growth, rng, 40, 120, 0.2)
            spin(growth, rng, *sorted(growth.across)[0], 6, 200)
            shake(growth, rng, 50, 60)
            weld(growth, rng, 30)
            self.assertEqual(growth.solid().faults(), "", n)
            faces = {tuple(sorted(f)) for f in growth.faces()}
            self.assertEqual(len(faces), len(growth.solid().surface.faces))
        self.assertGreater(min(ways.values()), 0, ways)


    def test_a_tet_over_a_vertex(self):
        """What is left of a tet that was cut into four, without the first: it fits in at two vertices, not at others."""
        whole = with_middle(bar(1))
        growth = Growth(whole.points, whole.tets[1:])
        self.assertEqual(growth.solid().faults(), "")
        done = [(a, b) for a, b in sorted(growth.across) if Growth(whole.points, whole.tets[1:]).onto_vertex(a, b)]
        self.assertEqual({a for a, _ in done}, {len(whole.points) - 1})
        self.assertTrue(growth.onto_vertex(*done[0]))
        self.assertEqual(len(growth.solid().tets), len(whole.tets))
        self.assertEqual(growth.solid().faults(), "")


def with_ends_glued(solid, n):
    """Identifies the square of the last cube of a spiral that lies on the first one's with it."""
    points, tets = solid.points, solid.tets
    first, last = tets[:6], tets[6 * (n - 1) :]
    mine = {points[v]: v for t in first for v in t if points[v][0] <= 10}
    theirs = {points[v]: v for t in last for v in t}
    same = {theirs[p]: v for p, v in mine.items() if p in theirs and p[1] == 10}
    renamed = [tuple(same.get(v, v) for v in t) for t in tets]
    used = sorted({v for t in renamed for v in t})
    new = {v: i for i, v in enumerate(used)}
    return [points[v] for v in used], [tuple(new[v] for v in t) for t in renamed]


if __name__ == "__main__":
    unittest.main()
