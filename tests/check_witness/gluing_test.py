"""Gluings around crossings and edges (rule `gluing`): what the solver says, against all gluings, on random conditions."""

import collections
import random
import unittest

import brute_force
import support  # noqa: F401
from witness_checker.sat.gluing import Condition, can_be_glued
from witness_checker.sat.names import name_layers

SEED, CASES = 1, 400


class Random:
    """Shells in some numbers of layers, regions between them, and conditions on these that fit."""

    def __init__(self, seed):
        self.rng = rng = random.Random(seed)
        most = rng.choice((1, 2, 2))
        self.layers = {("shell", k): rng.randint(0, most + 2) for k in range(rng.randint(4, 7))}
        for m in range(most + 3):
            self.layers["shell", 100 + m] = m  # one of each
        self.regions, self.names, self.conditions = {}, {}, []
        self.cut = rng.random() < 0.5
        for _ in range(rng.randint(2, 8)):
            self.add(rng.randint(0, most), rng.random() < 0.4)

    def shell(self, layers):
        return self.rng.choice([x for x, m in self.layers.items() if m == layers])

    def region(self, outer, inner):
        found = [r for r, shells in self.regions.items() if shells == (outer, inner)]
        if found and self.rng.random() < 0.6:
            return self.rng.choice(found)
        r = ("region", len(self.regions))
        self.regions[r] = (outer, inner)
        return r

    def changes(self, shells):
        out = []
        for sector, shell in enumerate(shells):
            if not self.cut or self.layers[shell] < 2 or self.rng.random() < 0.6:
                continue
            found = [x for x, s in self.names.items() if s == shell]
            name = self.rng.choice([*found, ("name", len(self.names))])
            self.names[name] = shell
            out.append((sector, name, self.rng.random() < 0.5))
        return tuple(out)

    def add(self, m, edge):
        outer, inner = self.shell(m), self.shell(m + 1)
        if edge:
            regions = self.region(outer, inner), self.region(outer, inner)
            self.conditions.append(Condition(regions, self.changes((outer, inner)), self.rng.randint(0, 2)))
            return
        other, none = self.shell(m + 1), self.shell(m + 2)
        pairs = ((outer, inner), (outer, other), (other, none), (inner, none))
        regions = tuple(self.region(*pair) for pair in pairs)
        self.conditions.append(Condition(regions, self.changes((outer, inner, other, none))))


class Gluings(unittest.TestCase):
    def test_against_all_gluings(self):
        print(f"seeds from {SEED}")
        seen = collections.Counter()
        for seed in range(SEED, SEED + CASES):
            case = Random(seed)
            problem = (case.regions, case.names, case.layers, case.conditions)
            with self.subTest(seed=seed):
                try:
                    expected = brute_force.can_be_glued(*problem)
                except brute_force.TooLong:
                    seen["too long"] += 1
                    continue
                self.assertEqual(can_be_glued(*problem), expected)
                seen[expected, "cut" if case.names else "whole"] += 1
        print(dict(seen))
        for key in ((True, "cut"), (True, "whole"), (False, "cut"), (False, "whole")):
            self.assertGreater(seen[key], 10)


class Names(unittest.TestCase):
    def test_every_shell_is_named_once(self):
        for seed in range(SEED, SEED + CASES):
            case = Random(seed)
            kinds = name_layers(case.regions, case.layers)
            named = [case.regions[r][kind == "given"] for r, kind in kinds.items() if kind != "free"]
            with self.subTest(seed=seed):
                self.assertEqual(len(named), len(set(named)))
                self.assertTrue(all(case.layers[shell] > 1 for shell in named))


if __name__ == "__main__":
    unittest.main()
