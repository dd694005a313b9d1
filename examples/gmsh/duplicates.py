#!/usr/bin/python3
"""What Gmsh makes of a mesh that overlaps itself, also after it has removed duplicate nodes.

Gmsh reads worm.msh; the labels of the faces are physical groups of surfaces, with their names, and the regions physical
groups of volumes. It also reads worm.mesh (labels and regions are numbers of entities) and the tets of worm.vtk.
"""
import os
import sys

import numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import overlap  # noqa: E402

TRIANGLE, TET = 2, 4  # kinds of elements


def elements(gmsh, kind, corners):
    """Of all elements of a kind the tags of their corners."""
    return gmsh.model.mesh.getElementsByType(kind)[1].reshape(-1, corners).astype(int)


def main():
    example = overlap.Example(__doc__, {"gmsh": "python3-gmsh"})
    surface = example.worm()
    path, vertices, tets = example.mesh(surface, "worm.msh")
    import gmsh
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(path)
    gmsh.model.mesh.removeDuplicateNodes()
    tags, points, _ = gmsh.model.mesh.getNodes()
    points = points.reshape(-1, 3)[numpy.argsort(tags)]
    corners = elements(gmsh, TET, 4) - 1
    example.equal("tets", len(corners), tets)
    example.all_vertices(points, vertices, surface)

    example.equal("boundary faces, as in the surface's file", elements(gmsh, TRIANGLE, 3).tolist(),
                  (surface.faces + 1).tolist(), figure_is=len)
    for dimension, group in gmsh.model.getPhysicalGroups(2):
        name = gmsh.model.getPhysicalName(dimension, group)
        example.equal(f"number of the group {name}", group, surface.labels.get(name))
        faces = sum(len(gmsh.model.mesh.getElements(2, entity)[1][0])
                    for entity in gmsh.model.getEntitiesForPhysicalGroup(2, group))
        example.equal(f"faces of the {name}", faces, numpy.count_nonzero(surface.label_of == group))
    example.equal("groups of tets", len(gmsh.model.getPhysicalGroups(3)), 1)
    gmsh.finalize()

    a, b, c, d = (points[corners[:, k]] for k in range(4))
    volumes = numpy.einsum("ij,ij->i", b - a, numpy.cross(c - a, d - a)) / 6
    example.equal("tets that are not positive", numpy.count_nonzero(volumes <= 0), 0)
    example.close("volume", volumes.sum(), surface.volume)
    example.values_of_layers(points, corners, numpy.zeros(len(points)))
    example.finish()


main()
