#!/usr/bin/python3
"""A cantilever on the same mesh by dolfinx and by `overtet solve elastic`: small and large displacements, two materials."""
import os
import sys
import time

import numpy
import worm

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import cantilever  # noqa: E402
import overlap  # noqa: E402


def energy(material, F):
    """By volume at rest."""
    import ufl
    mu = cantilever.YOUNG / (2 * (1 + cantilever.POISSON))
    lame = 2 * mu * cantilever.POISSON / (1 - 2 * cantilever.POISSON)
    if material == "st-venant-kirchhoff":
        E = (F.T * F - ufl.Identity(3)) / 2
        return mu * ufl.inner(E, E) + lame / 2 * ufl.tr(E) ** 2
    m, k = 4 * mu / 3, lame + 5 * mu / 6  # Smith, de Goes, Kim 2018, equations 14 and 16
    square, J = ufl.inner(F, F), ufl.det(F)
    return m / 2 * (square - 3) + k / 2 * (J - 1 - 3 * m / (4 * k)) ** 2 - m / 2 * ufl.ln(square + 1)


def solve(mesh, labels, surface, traction, material):
    """dolfinx' displacements by vertex, with Newton's method and MUMPS, the load in steps."""
    import ufl
    from dolfinx import fem
    from dolfinx.fem.petsc import NonlinearProblem
    from dolfinx.nls.petsc import NewtonSolver
    from mpi4py import MPI
    from petsc4py import PETSc
    space = fem.VectorFunctionSpace(mesh, ("CG", 1))
    u, v = fem.Function(space), ufl.TestFunction(space)
    load = fem.Constant(mesh, (0.0, 0.0, 0.0))
    ds = ufl.Measure("ds", domain=mesh, subdomain_data=labels)
    F = ufl.variable(ufl.Identity(3) + ufl.grad(u))
    stress = ufl.diff(energy(material, F), F)
    residual = ufl.inner(stress, ufl.grad(v)) * ufl.dx - ufl.inner(load, v) * ds(surface.labels["tip"])
    problem = NonlinearProblem(residual, u, [worm.fixed(space, labels, surface.labels["base"], fem.Function(space))])
    solver = NewtonSolver(MPI.COMM_SELF, problem)
    solver.rtol, solver.atol, solver.max_it = 1e-10, 1e-14, 50
    options = PETSc.Options()
    for name, value in (("ksp_type", "preonly"), ("pc_type", "lu"), ("pc_factor_mat_solver_type", "mumps")):
        options[solver.krylov_solver.getOptionsPrefix() + name] = value
    solver.krylov_solver.setFromOptions()
    began = time.monotonic()
    steps = 1 if traction < 1e-5 else 5
    for step in range(1, steps + 1):
        load.value[2] = -traction * step / steps
        if not solver.solve(u)[1]:
            sys.exit("dolfinx did not converge")
    seconds = time.monotonic() - began
    points, _, displacement = worm.at_vertices(mesh, u)
    return points, displacement, seconds


def main():
    example = overlap.Example(__doc__, {"dolfinx": "python3-dolfinx", "gmsh": "python3-gmsh", "vtkmodules": "python3-vtk9"})
    beam = cantilever.Cantilever(example, ("msh",))
    mesh, _, labels = worm.read(example.path("beam.msh"))
    example.equal("tets", mesh.topology.index_map(3).size_local, beam.tets)
    mine = cantilever.read(example.path("beam.vtu"))
    for material in ("st-venant-kirchhoff", "neo-hookean"):
        for what, traction in (("linear", cantilever.SMALL), ("large", cantilever.LARGE)):
            points, displacement, seconds = solve(mesh, labels, beam.surface, traction, material)
            # dolfinx numbers the vertices anew.
            row = {tuple(p): i for i, p in enumerate(points.tolist())}
            other = displacement[[row[tuple(p)] for p in mine.tolist()]]
            beam.compare(f"{material}, {what}", traction, material, other, seconds)
    example.finish()


if __name__ == "__main__":
    main()
