"""Discs of links (rules `link` and `shared`): what the solver says, against all gluings, on random links."""

import collections
import random
import unittest

import brute_force
import support
from angles import angle_b0
from witness_checker.geometry.euler import turns_needed
from witness_checker.sat.disc import bounds_a_disc, disc_formula
from witness_checker.sat.solver import can_be_satisfied

SEED, LINKS = 1, 200


def random_case(seed, corners):
    """A link that crosses itself or not, layers over it, and room on its edges."""
    link = support.random_link(seed, corners)
    if link is None:
        return None
    rng = random.Random(seed)
    extra = rng.choice((0, 0, 1, 2))
    w = {cell: m + extra for cell, m in link.least_layers().items()}
    most = [rng.choice((0, 0, 0, 1, 2)) for _ in range(link.corners)]
    if rng.random() < 0.05:
        most[0] = -1
    return link, w, most, extra


class Discs(unittest.TestCase):
    def test_discs_against_all_gluings(self):
        print(f"seeds from {SEED}")
        seen = collections.Counter()
        for seed in range(SEED, SEED + LINKS):
            case = random_case(seed, (4, 8))
            if case is None or not case[0].crossings:
                continue
            link, w, most, extra = case
            with self.subTest(seed=seed):
                value = angle_b0(link.out, link, w)
                self.assertEqual(turns_needed(link, w), value)
                try:
                    expected = brute_force.is_filled(link, w, value, most)
                except brute_force.TooLong:
                    seen["too long"] += 1
                    continue
                self.assertEqual(bounds_a_disc(link, w, most), expected)
                seen[expected, extra > 0] += 1
        print(dict(seen))
        self.assertGreater(min(seen[x, y] for x in (True, False) for y in (True, False)), 5)

    def test_other_surfaces_against_all_gluings(self):
        """Surfaces with handles, and what is not connected, must be told apart from each other."""
        print(f"seeds from {SEED}")
        seen = collections.Counter()
        for seed in range(SEED, SEED + LINKS // 4):
            case = random_case(seed, (3, 5))
            if case is None:
                continue
            link, w, most, _ = case
            most = [m + 1 for m in most]
            for number in (turns_needed(link, w) + k for k in (-2, -1, 0, 2)):
                with self.subTest(seed=seed, number=number):
                    try:
                        expected = brute_force.some_gluing(
                            link, w, most, lambda closed, turns: closed == 0 and turns == number
                        )
                    except brute_force.TooLong:
                        seen["too long"] += 1
                        continue
                    self.assertEqual(can_be_satisfied(disc_formula(link, w, most, number)), expected)
                    seen[expected, number - turns_needed(link, w)] += 1
        print(dict(seen))


if __name__ == "__main__":
    unittest.main()
