#!/usr/bin/python3
"""Makes a body of boxes, rounded off, and poses it so that its limbs pass through it and each other.

usage: body.py OUTPUT.obj [POSE]

POSE  rest (arms stretched out), waist (the hands sink into the waist, the shins pass through each other), or a number: so
      far from rest (0) to waist (1). Default: waist.

The groups of the OBJ file are torso, head, left_arm, left_hand, right_arm, right_hand, left_leg, left_foot, right_leg and
right_foot. All poses have the same vertices and faces in the same order.
"""
import math
import os
import sys

import numpy

ROOT = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..")
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(ROOT, "examples", "skinning"))
import hand  # noqa: E402

GROUPS = ["torso", "head", "left_arm", "left_hand", "right_arm", "right_hand", "left_leg", "left_foot", "right_leg", "right_foot"]
DEPTH, TORSO, ARM, LEG = 1.3, 5, 7, 8  # rows of boxes
SHOULDER, HIP = 1.5, 0.0  # where an arm begins, in x; where a leg begins, in y
ARM_LENGTH, LEG_LENGTH = 7.0, 8.0
# Where limbs bend, as a part of their length, over which part, and by how many degrees in the pose.
ARM_BENDS = [(.1, .3, -50), (.5, .3, -115)]
LEG_BENDS = [(.12, .3, -13), (.55, .3, -6)]


def boxes():
    """The boxes, as (i, j, k) with the group, and the coordinates of the planes between them."""
    x = [i - 1.5 for i in range(-ARM, ARM + 4)]
    y = [float(j) for j in range(-LEG, TORSO + 4)]
    first, low = ARM, LEG  # the torso's first column and row
    made = {}
    for i in range(3):
        for j in range(TORSO):
            made[first + i, low + j, 0] = "torso"
    for j in range(3):
        made[first + 1, low + TORSO + j, 0] = "head"
    for n in range(ARM):
        part = "hand" if n >= ARM - 2 else "arm"
        made[first - 1 - n, low + TORSO - 1, 0] = "right_" + part
        made[first + 3 + n, low + TORSO - 1, 0] = "left_" + part
    for n in range(LEG):
        part = "foot" if n >= LEG - 2 else "leg"
        made[first, low - 1 - n, 0] = "right_" + part
        made[first + 2, low - 1 - n, 0] = "left_" + part
    return made, (x, y, [-DEPTH / 2, DEPTH / 2])


def hull():
    """The quadrilaterals around the boxes, and of each the group; limbs are thinner than the torso, the head is round."""
    names = hand.GROUPS
    hand.GROUPS = GROUPS
    fingers, hand.FINGERS, rise, hand.THUMB_RISE = hand.FINGERS, [], hand.THUMB_RISE, 0
    try:
        points, quads, groups = hand.hull(*boxes())
    finally:
        hand.GROUPS, hand.FINGERS, hand.THUMB_RISE = names, fingers, rise
    head = points[:, 1] > TORSO + 1
    points[head, 0] *= 1.5
    points[head, 2] *= 1.2
    points[(abs(points[:, 0]) > SHOULDER) | (points[:, 1] < HIP), 2] *= .8
    return points, quads, groups


def bent(along, length, bends, share):
    """The middle line of a limb at each place along it, and its direction there."""
    def angle(t):
        return sum(math.radians(degrees * share) * hand.smooth((t - joint) / soft + .5) for joint, soft, degrees in bends)
    return *hand.line_along(along, length, angle), angle(along)


def posed(points, share):
    made = points.copy()
    for side in (-1, 1):
        mine = side * points[:, 0] > SHOULDER
        p = points[mine]
        across = p[:, 1] - (TORSO - .5)
        x, y, angle = bent((side * p[:, 0] - SHOULDER) / ARM_LENGTH, ARM_LENGTH, ARM_BENDS, share)
        made[mine, 0] = side * (SHOULDER + x - across * numpy.sin(angle))
        made[mine, 1] = TORSO - .5 + y + across * numpy.cos(angle)
        # Downwards: what is a limb's x is -y here.
        mine = (side * points[:, 0] > 0) & (points[:, 1] < HIP)
        p = points[mine]
        across = side * p[:, 0] - 1
        y, x, angle = bent((HIP - p[:, 1]) / LEG_LENGTH, LEG_LENGTH, LEG_BENDS, share)
        made[mine, 0] = side * (1 + x + across * numpy.cos(angle))
        made[mine, 1] = HIP - y + across * numpy.sin(angle)
    return made


def body(share=1.0, levels=2):
    """Points, triangles, and of each triangle its group."""
    points, quads, groups = hull()
    for _ in range(levels):
        points, quads, groups = hand.subdivided(points, quads, groups)
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    other = numpy.linalg.norm(a - c, axis=1) > numpy.linalg.norm(b - d, axis=1)
    quads[other] = numpy.roll(quads[other], -1, axis=1)
    faces = numpy.stack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    return posed(points, share), faces, numpy.repeat(groups, 2)


def write(path, points, faces, groups):
    with open(path, "w", encoding="ascii") as file:
        file.writelines("v %r %r %r\n" % tuple(p) for p in points.tolist())
        for number, name in enumerate(GROUPS):
            file.write(f"g {name}\n")
            file.writelines("f %d %d %d\n" % tuple(f) for f in (faces[groups == number] + 1).tolist())


def main():
    if not 2 <= len(sys.argv) <= 3 or not sys.argv[1].lower().endswith(".obj"):
        sys.exit(__doc__)
    pose = sys.argv[2] if len(sys.argv) == 3 else "waist"
    try:
        share = {"rest": 0.0, "waist": 1.0}.get(pose)
        share = float(pose) if share is None else share
    except ValueError:
        sys.exit(f"{pose}: no such pose. Poses are rest, waist, or a number.")
    write(sys.argv[1], *body(share))


if __name__ == "__main__":
    main()
