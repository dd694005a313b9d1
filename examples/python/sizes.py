#!/usr/bin/python3
"""How large tets are: everywhere alike, finer at one end, as few as possible."""
import models
import numpy as np
import overtet

V, F = models.figure_eight()


def told(what, mesh):
    a, b, c, d = (mesh.V[mesh.T[:, k]] for k in range(4))
    volumes = np.linalg.det(np.stack([b - a, c - a, d - a], axis=1)) / 6
    print("%-28s %6d tets, largest volume %.2g" % (what, len(mesh.T), volumes.max()))
    return mesh


plain = told("no wish", overtet.tetrahedralize(V, F))
told("max_volume=5e-4", overtet.tetrahedralize(V, F, max_volume=5e-4))
told("max_edge=.1", overtet.tetrahedralize(V, F, max_edge=.1))
told("coarse", overtet.tetrahedralize(V, F, coarse=True))

# The longest edge at each vertex: .05 at the right end, growing to the left.
sizes = .05 + .1 * (V[:, 0].max() - V[:, 0])
graded = told("sizes: .05 at the right end", overtet.tetrahedralize(V, F, sizes=sizes))
centres = graded.V[graded.T].mean(axis=1)
right = np.count_nonzero(centres[:, 0] > 0)
print("tets right and left of the middle:", right, len(graded.T) - right)
assert right > len(graded.T) / 2
