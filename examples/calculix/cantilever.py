#!/usr/bin/python3
"""A cantilever on the same mesh by CalculiX and by `overtet solve elastic`: small and large displacements.

With NLGEOM, *ELASTIC of CalculiX is St. Venant-Kirchhoff's law: the second Piola-Kirchhoff stress is linear in Green's strain.
"""
import os
import re
import shutil
import sys
import time

import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, ".."))
import cantilever  # noqa: E402
import overlap  # noqa: E402


def solve(example, beam, traction, name):
    """CalculiX's displacements, of which it prints seven digits."""
    shutil.copy(os.path.join(HERE, name + ".inp"), example.folder)
    with open(example.path("loads.inp"), "w", encoding="ascii") as file:
        file.writelines(f"{v + 1}, 3, {force:.12g}\n" for v, force in enumerate(beam.forces(traction)) if force)
    began = time.monotonic()
    said = example.run("ccx", name)
    seconds = time.monotonic() - began
    if "*ERROR" in said:
        sys.exit(said)
    with open(example.path(name + ".dat"), encoding="ascii") as file:
        last = re.split("displacements.*\n", file.read())[-1]  # of the last increment
    rows = numpy.array([[float(x) for x in line.split()] for line in last.splitlines() if line.strip()])
    displacement = numpy.zeros((beam.vertices, 3))
    displacement[rows[:, 0].astype(int) - 1] = rows[:, 1:]
    return displacement, seconds


def main():
    example = overlap.Example(__doc__, {"ccx": "calculix-ccx", "vtkmodules": "python3-vtk9"})
    beam = cantilever.Cantilever(example, ("inp",))
    for what, traction, name in (("linear", cantilever.SMALL, "cantilever_linear"), ("large", cantilever.LARGE, "cantilever_large")):
        other, seconds = solve(example, beam, traction, name)
        beam.compare(what, traction, "st-venant-kirchhoff", other, seconds)
    example.finish()


if __name__ == "__main__":
    main()
