"""What the tests of scripts/witness_checker share: its place, small surfaces, random links."""

import json
import os
import random
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPT = os.path.join(ROOT, "scripts", "check_witness")
sys.path.insert(0, os.path.join(ROOT, "scripts"))

from witness_checker.errors import Refuted  # noqa: E402
from witness_checker.geometry.link import Link  # noqa: E402
from witness_checker.geometry.surface import Surface  # noqa: E402

TET_POINTS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
TET_FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]


def flipped(faces):
    return [(a, c, b) for a, b, c in faces]


def joined(*models):
    """Several (points, faces) as one."""
    points, faces = [], []
    for more_points, more_faces in models:
        faces += [tuple(v + len(points) for v in f) for f in more_faces]
        points += more_points
    return points, faces


def random_cone(seed, corners=(4, 9), size=40):
    """A closed ring of random corners, seen from vertex 0, and from vertex 1: it crosses itself in most cases."""
    rng = random.Random(seed)
    n = rng.randint(*corners)
    points = [(0.0, 0.0, 0.0)] + [tuple(float(rng.randint(-size, size)) for _ in range(3)) for _ in range(n + 1)]
    faces = [(0, 2 + i, 2 + (i + 1) % n) for i in range(n)] + [(1, 2 + (i + 1) % n, 2 + i) for i in range(n)]
    return points, faces


def random_link(seed, corners, size=20):
    """A link of random corners, or None where it is not in general position."""
    points, faces = random_cone(seed, corners, size)
    ring = [tuple(map(int, p)) for p in points[2:]]
    try:
        return Link(ring)
    except Refuted:
        return None


def surface_of(model):
    return Surface(*model)


def off_text(model):
    points, faces = model
    lines = ["OFF", f"{len(points)} {len(faces)} 0"]
    lines += [" ".join(map(repr, p)) for p in points] + ["3 " + " ".join(map(str, f)) for f in faces]
    return "\n".join(lines) + "\n"


def answer(model, witness, environment=None):
    """Exit code and output of the script."""
    with tempfile.TemporaryDirectory() as folder:
        surface, report = os.path.join(folder, "s.off"), os.path.join(folder, "r.json")
        with open(surface, "w", encoding="ascii") as file:
            file.write(off_text(model))
        with open(report, "w", encoding="ascii") as file:
            json.dump({"status": "infeasible", "witness": witness}, file)
        done = subprocess.run(
            ["/usr/bin/python3", SCRIPT, surface, report], capture_output=True, text=True, check=False, env=environment
        )
        return done.returncode, done.stdout + done.stderr
