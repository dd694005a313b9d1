#!/usr/bin/python3
"""From arrays, or a file, to a tet mesh.

usage: quick_start.py [SURFACE [OUTPUT]]     for instance hand.obj hand.vtu
"""
import sys

import models
import numpy as np
import overtet

if len(sys.argv) > 1:
    surface = overtet.clean_up(overtet.read(sys.argv[1]))  # what the program does with every file
    V, F = surface.V, surface.F
else:
    V, F = models.figure_eight()

print(overtet.inspect(V, F))
mesh = overtet.tetrahedralize(V, F)
print(mesh, "smallest dihedral angle %.1f degrees" % mesh.quality.dihedral_min)

assert mesh.V[:len(V)].tobytes() == np.asarray(V, float).tobytes()  # the vertices are where they were, to the bit
assert np.array_equal(mesh.boundary, F)  # and the boundary is the surface
assert overtet.verify(V, F, mesh)  # exact, and shares no code with what made the mesh
print("tets where the solid covers itself twice:", np.count_nonzero(mesh.layers == 2))
if len(sys.argv) > 2:
    overtet.write(sys.argv[2], mesh)
