#!/usr/bin/python3
"""Skinning weights inside a fist: the finger that sinks into the palm moves, the palm around it does not.

The hand of hand.py is filled with tets in the pose in which it passes through itself. It gets a skeleton: a bone from the
wrist into the palm, and a chain of bones along each finger. `overtet solve weights` follows the bones from tet to tet,
so that those of a finger stay in the finger where it is inside the palm. There are two layers of tets there: in the finger's
the weight of the fingertip's bone is near 1, in the palm's near 0. On a mesh of the outer hull alone, the palm would
move with the finger. Then the middle finger is straightened a little, by `overtet solve skin`. Numpy is all that this needs.

usage: weights.py [OVERTET] [--keep DIR]
"""
import json
import os
import subprocess
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


# Where bones end along a finger, in parts of its length from the knuckle on.
BONES = [0.02, 0.25, 0.42, 0.62, 0.85]


def skeleton():
    """The handles, as `overtet solve weights` reads them: the bones of the flat hand, posed as the hand is."""
    palm = numpy.array([[2.7, hand.WRIST + 0.4, 0.0], [2.7, 2.0, 0.0]])
    handles = [{"name": "palm", "head": palm[0].tolist(), "tail": palm[1].tolist()}]
    for n, finger in enumerate(hand.FINGERS):
        x = n * (hand.WIDTH + hand.GAP) + hand.WIDTH / 2
        joints = numpy.array([[x, hand.KNUCKLES + t * hand.LENGTH[finger], 0.0] for t in BONES])
        joints = hand.posed(joints, "fist")
        for k in range(len(BONES) - 1):
            handles.append({"name": f"{finger}_{k + 1}", "head": joints[k].tolist(), "tail": joints[k + 1].tolist(),
                            "parent": f"{finger}_{k}" if k else "palm"})
    return {"handles": handles}


def write_json(path, what):
    with open(path, "w", encoding="ascii") as file:
        json.dump(what, file, indent=1)


def weights(overtet, mesh, folder):
    """The names of the bones, and of each the weight at each vertex: #V x #H."""
    handles, made = os.path.join(folder, "hand.json"), os.path.join(folder, "weights.csv")
    write_json(handles, skeleton())
    subprocess.run([overtet, "solve", "weights", mesh, "--handles", handles, "-o", made, "--quiet"], check=True)
    with open(made, encoding="ascii") as file:
        names = file.readline().strip().split(",")[1:]
    return names, numpy.loadtxt(made, delimiter=",", skiprows=1)[:, 1:]


def of_finger(names, W):
    """The weight of the finger beyond its first joint."""
    return W[:, [k for k, name in enumerate(names) if name.startswith(FINGER) and not name.endswith("_1")]].sum(axis=1)


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

    names, W = weights(example.program, mesh, example.folder)
    example.between("smallest weight", W.min(), 0, 0)
    example.between("largest weight", W.max(), 1, 1)
    example.small("difference between the sum of a vertex's weights and 1", abs(W.sum(axis=1) - 1).max())
    weight = of_finger(names, W)

    # At the fingertip's middle there are two tets, with two weights.
    rest = hand.rest()[0]
    mine = numpy.zeros(n, bool)
    mine[faces[groups == hand.GROUPS.index(FINGER)]] = True
    end = mine & (rest[:, 1] > hand.KNUCKLES + 0.9 * hand.LENGTH[FINGER])
    place = points[end].mean(axis=0)
    hit, inside = overlap.tets_at(P, T, place)
    example.equal("tets at one place, inside both the fingertip and the palm", len(hit), 2)
    palm, finger = sorted(float(w @ weight[T[t]]) for t, w in zip(hit, inside))
    example.between("weight there in the finger", finger, 0.95, 1)
    example.between("weight there in the palm", palm, 0, 0.05)

    # The finger is straightened at its first joint: the fingertip goes far, the palm around it stays.
    pose = example.path("pose.json")
    write_json(pose, {f"{FINGER}_2": {"axis": [1, 0, 0], "degrees": -30}})
    posed = example.path("posed.mesh")
    print("       " + example.run(example.program, "solve", "skin", mesh, "--weights", example.path("weights.csv"),
                                  "--handles", example.path("hand.json"), "--pose", pose, "-o", posed).strip())
    moved = numpy.linalg.norm(read_mesh(posed)[0] - P, axis=1)
    palm, finger = sorted(float(w @ moved[T[t]]) for t, w in zip(hit, inside))
    example.between("way of that place in the finger", finger, 0.5, 5)
    example.between("way of the same place in the palm", palm, 0, 0.1)
    example.finish()


if __name__ == "__main__":
    main()
