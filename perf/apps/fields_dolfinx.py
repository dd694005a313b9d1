#!/usr/bin/python3
"""Poisson's equation with dolfinx: seconds and memory of one run, as JSON (by rank 0).

usage: [mpirun -n RANKS] fields_dolfinx.py MESH.vtu ORDER SOLVER

SOLVER: mumps (a Cholesky factor), hypre or gamg (conjugate gradients with algebraic multigrid, to 1e-12). The compiler
of forms runs before the clock does, on a cube; the mesh's topology and the numbers of the nodes are not timed, either.
Seconds are the slowest rank's, memory is that of all ranks.
"""
import json
import logging
import os
import resource
import sys
import time

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

import dolfinx
import meshio
import numpy
import ufl
from dolfinx import fem
from dolfinx.fem import petsc
from mpi4py import MPI
from petsc4py import PETSc

SOLVERS = {
    "mumps": {"ksp_type": "preonly", "pc_type": "cholesky", "pc_factor_mat_solver_type": "mumps"},
    "hypre": {"ksp_type": "cg", "pc_type": "hypre", "pc_hypre_type": "boomeramg",
              "pc_hypre_boomeramg_strong_threshold": 0.5, "ksp_rtol": 1e-12},
    "gamg": {"ksp_type": "cg", "pc_type": "gamg", "ksp_rtol": 1e-12},
}


def solved(mesh, order, solver):
    """The solution, and the seconds of assembly and of the solver."""
    space = fem.FunctionSpace(mesh, ("Lagrange", order))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    a = fem.form(ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx)
    L = fem.form(fem.Constant(mesh, 1.0) * v * ufl.dx)
    mesh.topology.create_connectivity(2, 3)
    mesh.comm.barrier()
    begin = time.perf_counter()
    facets = dolfinx.mesh.exterior_facet_indices(mesh.topology)
    given = [fem.dirichletbc(0.0, fem.locate_dofs_topological(space, 2, facets), space)]
    A = petsc.assemble_matrix(a, bcs=given)
    A.assemble()
    A.setOption(PETSc.Mat.Option.SPD, True)
    b = petsc.assemble_vector(L)
    petsc.apply_lifting(b, [a], [given])
    b.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    petsc.set_bc(b, given)
    mesh.comm.barrier()
    middle = time.perf_counter()
    ksp = PETSc.KSP().create(mesh.comm)
    options = PETSc.Options()
    for name, value in SOLVERS[solver].items():
        options[name] = value
    ksp.setOperators(A)
    ksp.setFromOptions()
    x = b.duplicate()
    ksp.solve(b, x)
    end = time.perf_counter()
    return x, A, {"iterations": ksp.getIterationNumber(), "seconds_assembly": middle - begin, "seconds_solver": end - middle,
                  "converged": ksp.getConvergedReason() > 0}


def main():
    path, order, solver = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    logging.disable(logging.INFO)
    comm = MPI.COMM_WORLD
    cube = dolfinx.mesh.create_unit_cube(comm, 2, 2, 2)
    solved(cube, order, "hypre" if solver == "gamg" else solver)
    points, tets = numpy.zeros((0, 3)), numpy.zeros((0, 4), dtype=numpy.int64)
    if comm.rank == 0:
        read = meshio.read(path)
        tets = next(block.data for block in read.cells if block.type.startswith("tetra"))[:, :4].astype(numpy.int64)
        points = numpy.ascontiguousarray(read.points)
        del read
    shape = ufl.Mesh(ufl.VectorElement("Lagrange", "tetrahedron", 1))
    mesh = dolfinx.mesh.create_mesh(comm, tets, points, shape)
    x, A, figures = solved(mesh, order, solver)
    y = A.createVecLeft()
    A.mult(x, y)
    energy = 0.5 * x.dot(y)
    for name in ("seconds_assembly", "seconds_solver"):
        figures[name] = comm.allreduce(figures[name], op=MPI.MAX)
    figures.update(nodes=x.getSize(), energy=energy,
                   mib=comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, op=MPI.SUM))
    if comm.rank == 0:
        print(json.dumps(figures))


main()
