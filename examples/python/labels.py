#!/usr/bin/python3
"""Labels of faces on the way into a solver: to meshio, and to dolfinx without a file in between.

meshio (python3-meshio) is needed; dolfinx (python3-dolfinx) is used where it is there.
"""
import importlib.util
import sys
import tempfile

import models
import numpy as np
import overtet

if not importlib.util.find_spec("meshio"):
    print("SKIPPED: meshio is missing (Debian: python3-meshio).")
    sys.exit(77)

V, F = models.figure_eight()
middles = V[F].mean(axis=1)
labels = np.where(middles[:, 0] > 1.8, 1, np.where(middles[:, 0] < -1.8, 2, 3))  # right end, left end, the rest
surface = overtet.Surface(V, F, labels=labels, label_names={1: "warm", 2: "cold", 3: "free"})
mesh = overtet.tetrahedralize(surface)
assert np.array_equal(mesh.labels, labels)

made = mesh.to_meshio()
print(made)
with tempfile.TemporaryDirectory() as folder:
    made.write(folder + "/eight.vtk")  # one of meshio's formats
    overtet.write(folder + "/eight.msh", mesh)  # Overtet's own: with names as physical groups
    assert overtet.read_mesh(folder + "/eight.msh").label_names == surface.label_names

if importlib.util.find_spec("dolfinx"):
    import dolfinx
    import ufl
    from mpi4py import MPI

    element = ufl.Mesh(ufl.VectorElement("Lagrange", "tetrahedron", 1))
    domain = dolfinx.mesh.create_mesh(MPI.COMM_SELF, mesh.T.astype(np.int64), mesh.V, element)
    # dolfinx has vertices in another order: faces are found by the numbers that they had.
    number = np.array(domain.geometry.input_global_indices)
    domain.topology.create_connectivity(2, 0)
    domain.topology.create_connectivity(2, 3)
    outer = dolfinx.mesh.exterior_facet_indices(domain.topology)
    geometry = dolfinx.cpp.mesh.entities_to_geometry(getattr(domain, "_mesh", domain), 2, outer, False)
    label_of = {tuple(sorted(f)): label for f, label in zip(mesh.boundary.tolist(), labels)}
    tags = dolfinx.mesh.meshtags(domain, 2, outer, np.array(
        [label_of[tuple(sorted(number[corners]))] for corners in geometry], np.int32))
    area = dolfinx.fem.assemble_scalar(dolfinx.fem.form(
        dolfinx.fem.Constant(domain, 1.0) * ufl.Measure("ds", domain=domain, subdomain_data=tags)(1)))
    a, b, c = (V[F[labels == 1][:, k]] for k in range(3))
    expected = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    print("area of the warm end in dolfinx:", area, "in the surface:", expected)
    assert abs(area - expected) < 1e-9
else:
    print("dolfinx is not there: nothing solved.")
