#!/usr/bin/python3
"""Heat in a solid that overlaps itself, with FreeFEM (laplace.edp), and a patch test.

FreeFEM reads MEDIT .mesh files: readmesh3("worm.mesh"). The labels of the faces are references of triangles there, for
on(LABEL, ...) and int2d(Th, LABEL); the regions are references of tets.
"""
import json
import os
import sys

import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, ".."))
import overlap  # noqa: E402


def main():
    example = overlap.Example(__doc__, {"FreeFem++-nw": "freefem++", "/usr/lib/freefem++/msh3.so": "libfreefem++"})
    surface = example.worm()
    mesh, vertices, tets = example.mesh(surface, "worm.mesh")
    solution = example.path("solution.txt")
    # Debian keeps FreeFEM's plug-ins in a folder in which FreeFEM does not look by itself.
    os.environ.setdefault("FF_LOADPATH", "/usr/lib/freefem++")
    printed = example.run("FreeFem++-nw", "-v", "0", os.path.join(HERE, "laplace.edp"), mesh, solution)
    figures = {name: json.loads(value) for name, value in (line.split() for line in printed.splitlines())}

    example.equal("tets", figures["tets"], tets)
    example.equal("boundary faces", figures["boundary_faces"], len(surface.faces))
    example.equal("labels", figures["labels"], len(surface.labels))
    example.equal("regions", figures["regions"], 1)
    example.close("volume", figures["volume"], surface.volume)
    example.close("volume by the boundary", figures["volume_by_boundary"], surface.volume)
    for name, label in surface.labels.items():
        example.close(f"area of the {name}", figures[f"area_{label}"], surface.area(label))
    example.small("patch test: error of a linear solution", figures["patch_error"])

    numbers = numpy.loadtxt(solution)
    at_vertices, corners = numpy.split(numbers, [figures["vertices"]])
    points, temperature = at_vertices[:, :3], at_vertices[:, 3]
    example.all_vertices(points, vertices, surface)
    example.two_temperatures(points, corners.astype(int), temperature)
    example.finish()


main()
