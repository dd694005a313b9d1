#!/usr/bin/python3
"""A walk through the module, cell by cell (`# %%`: Spyder, VS Code and Jupyter run them one at a time).

usage: walk_through.py [FOLDER]     as a script it writes its pictures into FOLDER

Needs matplotlib (Debian: python3-matplotlib).
"""
# %% A surface that passes through itself
import importlib.util
import os
import sys

import models
import numpy as np
import overtet

if not importlib.util.find_spec("matplotlib"):
    print("SKIPPED: matplotlib is missing (Debian: python3-matplotlib).")
    sys.exit(77)
import matplotlib  # noqa: E402

FOLDER = sys.argv[1] if len(sys.argv) == 2 else None
if FOLDER:
    matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def show(name):
    plt.tight_layout()
    if FOLDER:
        plt.savefig(os.path.join(FOLDER, name + ".png"), dpi=110)
        plt.close()
    else:
        plt.show()


V, F = models.figure_eight()
print(len(V), "vertices,", len(F), "faces")

# %% What is known of it before any mesh is made
found = overtet.inspect(V, F)
print(found.verdict + ":", found.message)
print(len(found.pairs), "pairs of faces cross, in", len(found.curves), "curves; winding numbers", found.winding_min, "to",
      found.winding_max)

axes = plt.figure(figsize=(7, 4)).add_subplot(projection="3d")
axes.plot_trisurf(V[:, 0], V[:, 1], V[:, 2], triangles=F, color="#9bb8d3", alpha=.35, linewidth=0)
for curve in found.curves:
    points = curve["points"]
    if curve["closed"]:
        points = np.vstack([points, points[:1]])
    axes.plot(*points.T, color="#c0392b")
axes.set_box_aspect(np.ptp(V, axis=0))
axes.set_title("where the surface passes through itself")
show("1_curves")

# %% The mesh
mesh = overtet.tetrahedralize(V, F, progress=lambda stage, fraction: print("  %-12s %3.0f %%" % (stage, 100 * fraction)))
print(mesh, "-", mesh.quality)
for stage in mesh.report["stages"]:
    print("  %-24s %.3f s" % (stage["name"], stage["seconds"]))

# %% A cut: in the middle two layers of tets lie in one place, and know nothing of each other
centres = mesh.V[mesh.T].mean(axis=1)


def cut(axes, z, layers):
    """The triangles and quadrilaterals in which tets meet a plane."""
    for tet in mesh.T[(mesh.V[mesh.T][:, :, 2].min(axis=1) < z) & (mesh.V[mesh.T][:, :, 2].max(axis=1) > z) &
                      (mesh.layers == layers)]:
        p = mesh.V[tet]
        points = [p[a, :2] + (z - p[a, 2]) / (p[b, 2] - p[a, 2]) * (p[b, :2] - p[a, :2])
                  for a in range(4) for b in range(a) if (p[a, 2] - z) * (p[b, 2] - z) < 0]
        middle = np.mean(points, axis=0)
        points.sort(key=lambda q: np.arctan2(*(q - middle)[::-1]))
        axes.add_patch(plt.Polygon(points, facecolor=("#9bb8d3", "#e59866")[layers - 1], edgecolor="#444", linewidth=.3,
                                   alpha=.5))


axes = plt.figure(figsize=(8, 4)).add_subplot()
for count in (1, 2):
    cut(axes, 0.003, count)
axes.set_aspect("equal")
axes.autoscale_view()
axes.set_title("cut: tets in one layer, and in two that overlap")
show("2_cut")

# %% Dihedral angles
edges = [(0, 1, 2, 3), (0, 2, 3, 1), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 2, 0), (2, 3, 0, 1)]
p = mesh.V[mesh.T]
angles = []
for i, j, k, m in edges:
    along = p[:, j] - p[:, i]
    u, v = np.cross(along, p[:, k] - p[:, i]), np.cross(along, p[:, m] - p[:, i])
    cosine = (u * v).sum(axis=1) / np.linalg.norm(u, axis=1) / np.linalg.norm(v, axis=1)
    angles.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
angles = np.concatenate(angles)
assert abs(angles.min() - mesh.quality.dihedral_min) < 1e-6
plt.figure(figsize=(6, 3))
plt.hist(angles, bins=90, range=(0, 180), color="#9bb8d3")
plt.xlabel("dihedral angle (degrees), least %.1f" % angles.min())
show("3_angles")

# %% Is it right? Exact, and without the code that made it
verified = overtet.verify(V, F, mesh)
print(verified)
assert verified

# %% The overlap counts twice: the volume of the tets is the surface's signed volume
signed = np.linalg.det(V[F]).sum() / 6
print("volume of the tets %.6f, signed volume of the surface %.6f" % (mesh.quality.volume, signed))
assert abs(mesh.quality.volume - signed) < 1e-9

# %% A surface without a mesh, and one nearby that has one
ball = models.dented_ball()
try:
    overtet.tetrahedralize(*ball)
except overtet.Infeasible as error:
    print(error.explanation)
repair = overtet.repair(*ball)
print(repair, "at most %.2f %% of the diagonal" % (100 * repair.max_relative_move))
