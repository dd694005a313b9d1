"""What the examples share: a model that overlaps itself, the call of overtet, and checks that say what is wrong.

The model is the worm of scripts/make_sample, curled up by 420 degrees: for 60 of them its head and its tail are in the
same place. Its faces have three labels, from the groups of its OBJ file: tail and head (the round ends), and body.
"""
import argparse
import importlib.util
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
SKIPPED = 77  # what tests end with that could not be run
TOLERANCE = 1e-12  # relative: some thousand roundings of a direct solver

DEGREES = 420
# A place inside both layers: half-way between the worm's axis 30 degrees after its tail begins and a turn later, 30 before
# its head ends. If heat flows from one end to the other, its temperature is about 13/14 in one layer and 1/14 in the other.
PLACE_DEGREES = 30


def worm_axis(degrees):
    """The axis of the worm; what scripts/make_sample rolls up."""
    a = math.radians(degrees)
    r = 1 - 0.011 * a
    return numpy.array([r * math.sin(a), -r * math.cos(a), 1.05 * 0.3 * a / (2 * math.pi)])


PLACE = (worm_axis(PLACE_DEGREES) + worm_axis(PLACE_DEGREES + 360)) / 2


class Example:
    """A run of one example: a folder, the program, and the checks.

    packages: of Debian, by what the example needs of each: a Python module, a program or a file.
    """

    def __init__(self, description, packages):
        self.began = time.monotonic()
        parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
        parser.add_argument("overtet", nargs="?", default="overtet", help="the program (default: the one on PATH)")
        parser.add_argument("--keep", metavar="DIR", help="leaves all files there")
        options = parser.parse_args()
        missing = [package for needed, package in packages.items()
                   if not (os.path.exists(needed) if "/" in needed else
                           shutil.which(needed) or importlib.util.find_spec(needed))]
        if missing:
            print(f"SKIPPED: this example was NOT run: {' and '.join(missing)} (Debian) not installed; "
                  "`scripts/setup --examples` does that.")
            sys.exit(SKIPPED)
        self.program = shutil.which(options.overtet)
        if not self.program:
            sys.exit(f"{options.overtet}: no such program. Name overtet, or put it on PATH.")
        self.program = os.path.abspath(self.program)
        self.temporary = None
        if options.keep:
            self.folder = os.path.abspath(options.keep)
            os.makedirs(self.folder, exist_ok=True)
        else:
            self.temporary = tempfile.TemporaryDirectory()
            self.folder = self.temporary.name
        self.wrong = []

    def path(self, name):
        return os.path.join(self.folder, name)

    def run(self, *command):
        """What the command prints; the example ends if it fails."""
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
                              cwd=self.folder)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)}\nended with {done.returncode}:\n{done.stdout}")
        return done.stdout

    def worm(self):
        """Makes worm.obj."""
        path = self.path("worm.obj")
        self.run(sys.executable, "-B", os.path.join(HERE, "..", "scripts", "make_sample"), path, str(DEGREES))
        return Surface(path)

    def mesh(self, surface, output, *options):
        """Fills the surface with tets: the file, and its numbers of vertices and of tets."""
        said = self.run(self.program, "mesh", surface.path, "-o", self.path(output), *options)
        vertices, tets = re.search(r"(\d+) vertices, (\d+) tets", said).groups()
        return self.path(output), int(vertices), int(tets)

    # Checks: each prints a figure; finish() ends the example with what was wrong.

    def check(self, what, right, figure, wanted):
        print(f"{'ok   ' if right else 'WRONG'}  {what}: {figure}" + ("" if right else f", should be {wanted}"))
        if not right:
            self.wrong.append(what)

    def equal(self, what, figure, wanted, figure_is=lambda x: x):
        """figure_is: what to print of it."""
        self.check(what, figure == wanted, figure_is(figure), figure_is(wanted))

    def small(self, what, error, tolerance=TOLERANCE):
        self.check(what, error <= tolerance, f"{error:.2g}", f"at most {tolerance:g}")

    def close(self, what, figure, wanted, tolerance=TOLERANCE):
        """To within the tolerance, relative."""
        self.check(what, abs(figure - wanted) <= tolerance * abs(wanted), f"{figure:.15g}", f"{wanted:.15g}")

    def between(self, what, figure, low, high):
        self.check(what, low <= figure <= high, f"{figure:.6g}", f"between {low:g} and {high:g}")

    def all_vertices(self, points, count, surface):
        """The solver has all vertices that are in the file, each in a place of its own, the surface's to the bit."""
        self.equal("vertices", len(points), count)
        places = {tuple(p) for p in points.tolist()}
        self.equal("vertices after merging equal ones", len(places), count)
        self.equal("vertices of the surface among them", sum(tuple(p) in places for p in surface.points.tolist()),
                   len(surface.points))

    def values_of_layers(self, points, tets, values):
        """Without the worm's middle, the mesh is in two parts; a value in each, where both are: at PLACE, the smaller first.

        values: a number at each point.
        """
        angle = numpy.degrees(numpy.arctan2(points[:, 0], -points[:, 1])) % 360
        ends = tets[numpy.all((angle[tets] < 150) | (angle[tets] > 270), axis=1)]
        self.equal("parts that hang together, of all but the middle", count_parts(ends), 2)
        hit, weights = tets_at(points, tets, PLACE)
        self.equal("tets at one place there", len(hit), 2)
        return sorted(float(w @ values[tets[t]]) for t, w in zip(hit, weights)) if len(hit) == 2 else [math.nan] * 2

    def two_temperatures(self, points, tets, temperature):
        """The ends of the worm are in one place and have different temperatures: the tail is kept at 1, the head at 0."""
        cold, hot = self.values_of_layers(points, tets, temperature)
        self.between("temperature at that place in the tail, which is kept at 1", hot, 0.9, 1.0)
        self.between("temperature at the same place in the head, which is kept at 0", cold, 0.0, 0.1)

    def finish(self):
        print(f"{time.monotonic() - self.began:.1f} s")
        if self.wrong:
            sys.exit("WRONG: " + "; ".join(self.wrong))


class Surface:
    """What an OBJ file holds: points, faces (corners counted from 0), and of each face the number of its group.

    labels: the numbers by the groups' names. Numbers are given in the order of the file, from 1, as overtet does it.
    """

    def __init__(self, path):
        self.path, self.labels = path, {}
        points, faces, label_of = [], [], []
        with open(path, encoding="ascii") as file:
            for line in file:
                kind, *rest = line.split()
                if kind == "v":
                    points.append([float(x) for x in rest])
                elif kind == "g":
                    label = self.labels.setdefault(rest[0], len(self.labels) + 1)
                elif kind == "f":
                    faces.append([int(x) - 1 for x in rest])
                    label_of.append(label)
        self.points, self.faces, self.label_of = numpy.array(points), numpy.array(faces), numpy.array(label_of)
        a, b, c = (self.points[self.faces[:, k]] for k in range(3))
        self._area_vectors = numpy.cross(b - a, c - a) / 2
        # With sign; what is covered twice counts twice.
        self.volume = math.fsum(numpy.einsum("ij,ij->i", a, self._area_vectors) / 3)

    def area(self, label):
        return math.fsum(numpy.linalg.norm(self._area_vectors[self.label_of == label], axis=1))

    def area_vector(self, label):
        """The sum of normals times areas: what a pressure of -1 pulls with."""
        return numpy.array([math.fsum(x) for x in self._area_vectors[self.label_of == label].T])


def tets_at(points, tets, place):
    """The tets that the place is in, and of each the weights of its corners."""
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    weights = numpy.linalg.solve(numpy.stack([b - a, c - a, d - a], axis=2), (place - a)[:, :, None])[:, :, 0]
    weights = numpy.column_stack([1 - weights.sum(axis=1), weights])
    hit = numpy.flatnonzero(numpy.all(weights >= 0, axis=1))
    return hit, weights[hit]


def count_parts(tets):
    """Of how many parts, that have no vertex in common, these tets are."""
    up = {}

    def top(v):
        while up.setdefault(v, v) != v:
            up[v] = up[up[v]]
            v = up[v]
        return v
    for tet in tets.tolist():
        for v in tet[1:]:
            up[top(v)] = top(tet[0])
    return len({top(v) for v in list(up)})
