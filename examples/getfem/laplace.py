#!/usr/bin/python3
"""Heat in a solid that overlaps itself, with GetFEM, and a patch test.

GetFEM reads Gmsh files: getfem.Mesh("import", "gmsh", "worm.msh"). It merges points in the same place; no two vertices of
the mesh are. Take version 4.1, not 2.2: GetFEM has one list of regions for groups of tets and groups of faces. If both have
a number in common, it gives the faces another one (and warns), but in files of version 2.2 it throws them together.
"""
import os
import sys

import numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import overlap  # noqa: E402


def main():
    example = overlap.Example(__doc__, {"getfem": "python3-getfem"})
    surface = example.worm()
    path, vertices, tets = example.mesh(surface, "worm.msh")
    import getfem
    getfem.util_trace_level(0)
    getfem.util_warning_level(0)
    mesh = getfem.Mesh("import", "gmsh", path)
    example.equal("tets", mesh.nbcvs(), tets)
    example.equal("boundary faces", mesh.outer_faces().shape[1], len(surface.faces))

    # The solid is region 1, so the tail, label 1, is the number that is no label.
    regions = dict(surface.labels)
    regions["tail"], = (n for n in mesh.regions() if n not in surface.labels.values())
    boundary = 1000
    mesh.set_region(boundary, mesh.outer_faces())
    integrals = getfem.MeshIm(mesh, 2)

    def integral(expression, region=-1):
        return getfem.asm_generic(integrals, 0, expression, region)
    example.close("volume", integral("1"), surface.volume)
    example.close("volume by the boundary", integral("X.Normal/3", boundary), surface.volume)
    for name, label in surface.labels.items():
        example.equal(f"faces of the {name}", mesh.region(regions[name]).shape[1],
                      numpy.count_nonzero(surface.label_of == label))
        example.close(f"area of the {name}", integral("1", regions[name]), surface.area(label))

    space = getfem.MeshFem(mesh, 1)
    space.set_classical_fem(1)

    def solve(values_on):
        """The temperature, if it has these values (a list of expressions and where) on the boundary."""
        model = getfem.Model("real")
        model.add_fem_variable("u", space)
        model.add_Laplacian_brick(integrals, "u")
        for k, (expression, region) in enumerate(values_on):
            model.add_initialized_fem_data(f"value{k}", space, space.eval(expression))
            model.add_Dirichlet_condition_with_simplification("u", region, f"value{k}")
        model.solve("lsolver", "mumps")
        return model.variable("u")

    # Patch test: a linear function on the whole boundary is the solution inside.
    linear = "1 + x + 2*y + 3*z"
    wanted = space.eval(linear)
    example.small("patch test: error of a linear solution",
                  numpy.abs(solve([(linear, boundary)]) - wanted).max() / numpy.abs(wanted).max())

    # The tail is kept at 1, the head at 0, and no heat gets through the body's surface.
    temperature = solve([("1", regions["tail"]), ("0", regions["head"])])
    corners = space.basic_dof_from_cvid()[0].reshape(-1, 4)
    points = space.basic_dof_nodes().T
    example.all_vertices(mesh.pts().T, vertices, surface)
    example.two_temperatures(points, corners, temperature)
    example.finish()


main()
