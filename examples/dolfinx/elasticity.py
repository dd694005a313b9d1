#!/usr/bin/python3
"""Linear elasticity in a solid that overlaps itself, with dolfinx, and patch tests.

The surfaces of two layers in one place are no contact and no glue: what pulls at the head moves the tail only through
the body, all the way round.
"""
import numpy
import worm

YOUNG, POISSON, PULL = 1.0, 0.3, 1.0


def main():
    example, surface, vertices, mesh, labels = worm.start(__doc__)
    import ufl
    from dolfinx import fem

    mu, lame = YOUNG / (2 * (1 + POISSON)), YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))

    def stress(u):
        return 2 * mu * ufl.sym(ufl.grad(u)) + lame * ufl.div(u) * ufl.Identity(3)
    space = fem.VectorFunctionSpace(mesh, ("CG", 1))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    a = ufl.inner(stress(u), ufl.sym(ufl.grad(v))) * ufl.dx
    nothing = ufl.inner(fem.Constant(mesh, (0.0, 0.0, 0.0)), v) * ufl.dx

    # Patch test: constant strain on the whole boundary is constant strain inside.
    matrix = numpy.array([[1.0, 0.5, -0.2], [0.1, -0.7, 0.3], [0.4, 0.2, 0.6]])
    linear = fem.Function(space)
    linear.interpolate(lambda x: matrix @ x + numpy.array([[0.1], [0.2], [0.3]]))
    patch = worm.solve(a, nothing, [worm.fixed(space, labels, None, linear)])
    example.small("patch test: error of a linear displacement",
                  numpy.abs(patch.x.array - linear.x.array).max() / numpy.abs(linear.x.array).max())
    strain = (matrix + matrix.T) / 2
    constant = 2 * mu * strain + lame * numpy.trace(strain) * numpy.eye(3)
    stresses = fem.Function(fem.TensorFunctionSpace(mesh, ("DG", 0)))
    stresses.interpolate(fem.Expression(stress(patch), stresses.function_space.element.interpolation_points()))
    example.small("patch test: error of the constant stress",
                  numpy.abs(stresses.x.array.reshape(-1, 3, 3) - constant).max() / numpy.abs(constant).max())

    # The tail is held, the head pulled along z.
    ds = ufl.Measure("ds", domain=mesh, subdomain_data=labels)
    held, head = fem.Function(space), surface.labels["head"]
    pull = fem.Constant(mesh, (0.0, 0.0, PULL))
    moved = worm.solve(a, ufl.inner(pull, v) * ds(head), [worm.fixed(space, labels, surface.labels["tail"], held)])
    work = fem.assemble_scalar(fem.form(ufl.inner(stress(moved), ufl.sym(ufl.grad(moved))) * ufl.dx))
    done = fem.assemble_scalar(fem.form(ufl.inner(pull, moved) * ds(head)))
    example.close("work of the stresses, which is that of the force", work, done, 1e-9)
    points, corners, displacement = worm.at_vertices(mesh, moved)
    example.all_vertices(points, vertices, surface)
    tail, head = example.values_of_layers(points, corners, numpy.linalg.norm(displacement, axis=1))
    example.between("share of the head's displacement that the tail has at that place", tail / head, 0.0, 0.05)
    example.finish()


main()
