#!/usr/bin/python3
"""Skinning weights inside a fist: the finger that sinks into the palm moves, the palm around it does not.

The hand of hand.py is filled with tets in the pose in which it passes through itself. The weight of the middle finger is a
harmonic function on the tets: 1 at the finger's tip, 0 at the wrist, the palm and the other fingers. Where the
fingertip is inside the palm, there are two layers of tets: in the finger's the weight is near 1, in the palm's near 0. On a
mesh of the outer hull alone, the palm would move with the finger. Numpy is all that this needs.

usage: weights.py [OVERTET] [--keep DIR]
"""
import os
import sys

import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..")]

import hand  # noqa: E402
import overlap  # noqa: E402

FINGER = "middle"


def read_mesh(path):
    """Points and tets of a MEDIT file."""
    with open(path, encoding="ascii") as file:
        words = file.read().split()

    def block(name, width, kind):
        at = words.index(name)
        n = int(words[at + 1])
        return numpy.array(words[at + 2:at + 2 + n * width], kind).reshape(n, width)
    return block("Vertices", 4, float)[:, :3], block("Tetrahedra", 5, int)[:, :4] - 1


def laplacian(points, tets):
    """Of linear finite elements: the pairs of vertices, and what stands at each in the matrix."""
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    volume = numpy.einsum("ij,ij->i", numpy.cross(b - a, c - a), d - a) / 6
    normals = [numpy.cross(d - b, c - b), numpy.cross(c - a, d - a), numpy.cross(d - a, b - a), numpy.cross(b - a, c - a)]
    rows, columns, values = [], [], []
    for i in range(4):
        for j in range(4):
            rows.append(tets[:, i])
            columns.append(tets[:, j])
            values.append(numpy.einsum("ij,ij->i", normals[i], normals[j]) / (36 * volume))
    return numpy.concatenate(rows), numpy.concatenate(columns), numpy.concatenate(values)


def harmonic(points, tets, fixed, given):
    """Conjugate gradients with the diagonal as preconditioner: `given` where `fixed`, harmonic elsewhere."""
    rows, columns, values = laplacian(points, tets)
    n, free = len(points), ~fixed

    def times(x):
        return numpy.bincount(rows, values * x[columns], minlength=n)
    diagonal = numpy.bincount(rows[rows == columns], values[rows == columns], minlength=n)
    x = numpy.where(fixed, given, 0.0)
    r = -times(x) * free
    z = r / diagonal
    p, rz, first = z, r @ z, numpy.linalg.norm(r)
    for step in range(10 * n):
        if numpy.linalg.norm(r) <= 1e-10 * first:
            break
        q = times(p) * free
        alpha = rz / (p @ q)
        x, r = x + alpha * p, r - alpha * q
        z = r / diagonal
        p, rz = z + (r @ z) / rz * p, r @ z
    return x, step


def weights(points, tets, faces, groups):
    """Of each vertex of the mesh the weight of the finger; the steps that took; which of the hand's vertices are its tip."""
    # The bones, where the weight is given, by the places in the flat hand.
    rest = hand.rest()[0]
    n = len(rest)
    tip = numpy.zeros(n, bool)
    tip[faces[groups == hand.GROUPS.index(FINGER)]] = True
    tip &= rest[:, 1] > hand.KNUCKLES + 0.6 * hand.LENGTH[FINGER]
    others = numpy.zeros(n, bool)
    for name in hand.GROUPS:
        if name not in (FINGER, "palm"):
            others[faces[groups == hand.GROUPS.index(name)]] = True
    others |= rest[:, 1] < 0.6 * hand.KNUCKLES
    fixed, given = numpy.zeros(len(points), bool), numpy.zeros(len(points))
    fixed[:n] = tip | others
    given[:n] = tip
    return *harmonic(points, tets, fixed, given), tip


def main():
    example = overlap.Example(__doc__, {"numpy": "python3-numpy"})
    points, faces, groups = hand.hand("fist")
    surface = example.path("fist.obj")
    hand.write(surface, points, faces, groups)
    mesh, vertices, tets = example.mesh(overlap.Surface(surface), "fist.mesh")
    P, T = read_mesh(mesh)
    example.equal("vertices", len(P), vertices)
    example.equal("tets", len(T), tets)
    n = len(points)
    example.equal("vertices of the surface at their places", int(numpy.sum(numpy.all(P[:n] == points, axis=1))), n)

    weight, steps, tip = weights(P, T, faces, groups)
    print(f"       {steps} steps of conjugate gradients")
    example.between("smallest weight", weight.min(), -0.05, 0.0)
    example.between("largest weight", weight.max(), 1.0, 1.05)

    # At the fingertip's middle there are two tets, with two weights.
    end = tip & (hand.rest()[0][:, 1] > hand.KNUCKLES + 0.9 * hand.LENGTH[FINGER])
    place = points[end].mean(axis=0)
    hit, inside = overlap.tets_at(P, T, place)
    example.equal("tets at one place, inside both the fingertip and the palm", len(hit), 2)
    palm, finger = sorted(float(w @ weight[T[t]]) for t, w in zip(hit, inside))
    example.between("weight there in the finger", finger, 0.9, 1.05)
    example.between("weight there in the palm", palm, -0.05, 0.5)
    example.finish()


if __name__ == "__main__":
    main()
