"""The worm as a mesh of dolfinx, and what both examples measure of it."""
import logging
import os
import sys

import numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import overlap  # noqa: E402

# Without this, threads of BLAS would get into each other's way in so small a problem.
os.environ.setdefault("OMP_NUM_THREADS", "1")


def start(description):
    """The example, the worm's surface, the vertices in its mesh file, and the mesh with labels and regions, checked."""
    example = overlap.Example(description, {"dolfinx": "python3-dolfinx", "gmsh": "python3-gmsh"})
    surface = example.worm()
    path, vertices, tets = example.mesh(surface, "worm.msh")
    mesh, regions, labels = read(path)
    check(example, surface, mesh, regions, labels, tets)
    return example, surface, vertices, mesh, labels


def read(path):
    """Gmsh files: the mesh, the labels of its boundary faces and the regions of its cells, from the physical groups.

    `gmshio.read_from_msh(path, ...)` does the same; that of Debian 12 (0.5.2) ends with a NameError.
    """
    import gmsh
    from dolfinx.io import gmshio
    from mpi4py import MPI
    logging.getLogger().addFilter(lambda record: record.levelno >= logging.WARNING)  # the compiler of forms tells much
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(path)
    mesh, regions, labels = gmshio.model_to_mesh(gmsh.model, MPI.COMM_SELF, 0, gdim=3)
    gmsh.finalize()
    return mesh, regions, labels


def check(example, surface, mesh, regions, labels, tets):
    """Numbers, volume and areas."""
    import dolfinx
    import ufl
    from dolfinx import fem
    example.equal("tets", mesh.topology.index_map(3).size_local, tets)
    example.equal("tets with a region", len(regions.values), tets)
    mesh.topology.create_connectivity(2, 3)
    example.equal("boundary faces", len(dolfinx.mesh.exterior_facet_indices(mesh.topology)), len(surface.faces))

    def integral(form):
        return fem.assemble_scalar(fem.form(form))
    one = fem.Constant(mesh, 1.0)
    example.close("volume", integral(one * ufl.dx(domain=mesh)), surface.volume)
    ds = ufl.Measure("ds", domain=mesh, subdomain_data=labels)
    example.close("volume by the boundary",
                  integral(ufl.dot(ufl.SpatialCoordinate(mesh), ufl.FacetNormal(mesh)) / 3 * ds), surface.volume)
    for name, label in surface.labels.items():
        example.equal(f"faces of the {name}", len(labels.find(label)), numpy.count_nonzero(surface.label_of == label))
        example.close(f"area of the {name}", integral(one * ds(label)), surface.area(label))


def fixed(space, labels, label, value):
    """A boundary condition on the faces with a label (None: on all)."""
    from dolfinx import fem
    facets = labels.indices if label is None else labels.find(label)
    return fem.dirichletbc(value, fem.locate_dofs_topological(space, 2, facets))


def solve(a, L, conditions):
    """By a direct solver."""
    from dolfinx.fem.petsc import LinearProblem
    options = {"ksp_type": "preonly", "pc_type": "lu", "pc_factor_mat_solver_type": "mumps"}
    return LinearProblem(a, L, bcs=conditions, petsc_options=options).solve()


def at_vertices(mesh, u):
    """The mesh's vertices, the corners of its cells, and the values of a linear function at the vertices."""
    corners = mesh.geometry.dofmap.array.reshape(-1, 4)
    dofs = u.function_space.dofmap.list.array.reshape(-1, 4)
    size = u.function_space.dofmap.bs
    values = numpy.empty((len(mesh.geometry.x), size))
    values[corners] = u.x.array.reshape(-1, size)[dofs]
    return mesh.geometry.x, corners, values[:, 0] if size == 1 else values
