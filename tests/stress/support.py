"""What the tests of scripts/hard_models share: its place, small solids, programs that are made up."""

import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPT = os.path.join(ROOT, "scripts", "stress")
sys.path.insert(0, os.path.join(ROOT, "scripts"))

from hard_models.complex import Solid  # noqa: E402
from hard_models.kinds.built import cubes  # noqa: E402


def bar(n, scale=10):
    """Cubes in a row."""
    return cubes([(i, 0, 0) for i in range(n)], [None, *range(n - 1)], scale).solid()


def spiral(n):
    """Cubes around an edge, n quarters of a turn."""
    around = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    return cubes([around[i % 4] for i in range(n)], [None, *range(n - 1)], 10).solid()


def with_middle(solid):
    """The first tet cut into four at a point inside."""
    a, b, c, d = solid.tets[0]
    points = [tuple(4 * x for x in p) for p in solid.points]
    points.append(tuple(sum(solid.points[v][k] for v in (a, b, c, d)) for k in range(3)))
    m = len(points) - 1
    return Solid(points, [(m, b, c, d), (a, m, c, d), (a, b, m, d), (a, b, c, m)] + solid.tets[1:])


def program(folder, body, name="overtet"):
    """A program in Python that behaves as `body` says; `surface`, `output` and `report` are what its arguments name."""
    path = os.path.join(folder, name)
    with open(path, "w", encoding="ascii") as file:
        file.write("#!/usr/bin/python3 -B\nimport json, os, sys, time\n"
                   f"sys.path.insert(0, {os.path.join(ROOT, 'scripts')!r})\n"
                   "command, surface, output = sys.argv[1], sys.argv[2], sys.argv[4]\n"
                   "report = sys.argv[sys.argv.index('--report') + 1] if '--report' in sys.argv else None\n"
                   "def faces():\n"
                   "    return int(open(surface).read().split('\\n', 2)[1].split()[1])\n" + body)
    os.chmod(path, 0o755)
    return path
