#!/usr/bin/python3
"""Heat in a solid that overlaps itself, with dolfinx, and a patch test.

dolfinx reads Gmsh files (worm.msh): the labels of the faces and the regions of the tets are tags of its mesh.
"""
import numpy
import worm


def main():
    example, surface, vertices, mesh, labels = worm.start(__doc__)
    import ufl
    from dolfinx import fem

    space = fem.FunctionSpace(mesh, ("CG", 1))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    a = ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx
    L = fem.Constant(mesh, 0.0) * v * ufl.dx

    # Patch test: a linear function on the whole boundary is the solution inside.
    linear = fem.Function(space)
    linear.interpolate(lambda x: 1 + x[0] + 2 * x[1] + 3 * x[2])
    patch = worm.solve(a, L, [worm.fixed(space, labels, None, linear)])
    error = numpy.abs(patch.x.array - linear.x.array).max() / numpy.abs(linear.x.array).max()
    example.small("patch test: error of a linear solution", error)

    # The tail is kept at 1, the head at 0, and no heat gets through the body's surface.
    one, zero = fem.Function(space), fem.Function(space)
    one.x.array[:] = 1
    heat = worm.solve(a, L, [worm.fixed(space, labels, surface.labels["tail"], one),
                             worm.fixed(space, labels, surface.labels["head"], zero)])
    points, corners, temperature = worm.at_vertices(mesh, heat)
    example.all_vertices(points, vertices, surface)
    example.two_temperatures(points, corners, temperature)
    example.finish()


main()
