#!/usr/bin/python3
"""Makes a hand of boxes, rounded off, and poses it.

usage: hand.py OUTPUT.obj [POSE]

POSE  rest (flat), fist (the fingers sink into the palm), crossed (the index finger passes through the middle finger), or
      a number: so far from rest (0) to fist (1), and beyond. Default: fist.

The groups of the OBJ file are wrist, palm, thumb, index, middle, ring and little. All poses have the same vertices and
faces in the same order.
"""
import math
import os
import sys

import numpy

FINGERS = ["index", "middle", "ring", "little"]
GROUPS = ["wrist", "palm", "thumb", *FINGERS]
WIDTH, GAP, DEPTH = 1.2, 0.2, 1.3  # of a finger, between fingers, of the hand
KNUCKLES, WRIST = 5.6, -2.6  # where palm and forearm end
LENGTH = {"index": 5.4, "middle": 6.0, "ring": 5.6, "little": 4.9}
ROWS = 7  # boxes along a finger
JOINTS = [0.15, 0.42, 0.68]  # along a finger
THUMB_RISE = 0.6
SOFT = 0.36  # so much of a finger bends at a joint
# Degrees at the three joints of each finger, and how far the knuckle turns sideways first.
POSES = {
    "rest": {},
    "fist": {"index": (70, 110, 80, 0), "middle": (70, 110, 80, 0), "ring": (70, 110, 80, 0), "little": (70, 105, 75, 0)},
    "crossed": {"index": (10, 12, 10, -17), "middle": (6, 8, 6, 3), "ring": (70, 100, 60, 0), "little": (70, 100, 60, 0)},
}


def boxes():
    """The boxes that the hand is made of, as (i, j, k) with the group; and the coordinates of the planes between them."""
    x = [-3.6, -2.4, -1.2, 0.0]
    for n in range(4):
        if n:
            x.append(x[-1] + GAP)
        x.append(x[-1] + WIDTH)
    y = [WRIST, WRIST / 2, 0.0, 1.4, 3.0, 4.4, KNUCKLES] + [KNUCKLES + n + 1 for n in range(ROWS)]
    z = [-DEPTH / 2, DEPTH / 2]
    made = {}
    for i in range(3, 10):
        for j in range(6):
            if j >= 2 or 4 <= i <= 8:
                made[i, j, 0] = "palm" if j >= 2 else "wrist"
    for n, finger in enumerate(FINGERS):
        for j in range(6, 6 + ROWS):
            made[3 + 2 * n, j, 0] = finger
    for i in range(3):
        made[i, 3, 0] = "thumb"
    return made, (x, y, z)


def hull(made, planes):
    """The quadrilaterals around the boxes, and of each the group."""
    number, points, quads, groups = {}, [], [], []

    def corner(c):
        if c not in number:
            number[c] = len(points)
            points.append([planes[axis][c[axis]] for axis in range(3)])
        return number[c]
    for box, group in made.items():
        for axis in range(3):
            for side in (0, 1):
                beside = list(box)
                beside[axis] += 2 * side - 1
                if tuple(beside) in made:
                    continue
                u, v = (axis + 1) % 3, (axis + 2) % 3
                around = []
                for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    c = list(box)
                    c[axis] += side
                    c[u] += du
                    c[v] += dv
                    around.append(corner(tuple(c)))
                quads.append(around if side else around[::-1])
                groups.append(GROUPS.index(group))
    points = numpy.array(points)
    points[:, 1] -= THUMB_RISE * numpy.minimum(points[:, 0], 0)  # the thumb points upwards
    # Fingers have lengths of their own.
    for n, finger in enumerate(FINGERS):
        low = planes[0][3 + 2 * n]
        mine = (points[:, 0] >= low) & (points[:, 0] <= low + WIDTH) & (points[:, 1] > KNUCKLES)
        points[mine, 1] = KNUCKLES + (points[mine, 1] - KNUCKLES) * LENGTH[finger] / ROWS
    return points, numpy.array(quads), numpy.array(groups)


def subdivided(points, quads, groups):
    """One step of Catmull and Clark, 1978."""
    n, middles = len(points), points[quads].mean(axis=1)
    ends = numpy.stack([quads, numpy.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, of = numpy.unique(numpy.sort(ends, axis=1), axis=0, return_inverse=True)
    of = of.reshape(-1)
    beside = numpy.zeros((len(edges), 3))  # sum of the middles of an edge's two faces
    numpy.add.at(beside, of, numpy.repeat(middles, 4, axis=0))
    on_edges = (points[edges].sum(axis=1) + beside) / 4
    valence = numpy.bincount(edges.ravel(), minlength=n)[:, None]
    faces, halves = numpy.zeros((n, 3)), numpy.zeros((n, 3))
    numpy.add.at(faces, quads.ravel(), numpy.repeat(middles, 4, axis=0))
    numpy.add.at(halves, edges.ravel(), numpy.repeat(points[edges].mean(axis=1), 2, axis=0))
    old = (faces / valence + 2 * halves / valence + (valence - 3) * points) / valence
    first, last = n + of.reshape(-1, 4), n + len(edges) + numpy.arange(len(quads))
    finer = [[quads[:, k], first[:, k], last, first[:, k - 1]] for k in range(4)]
    finer = numpy.array(finer).transpose(2, 0, 1).reshape(-1, 4)
    return numpy.concatenate([old, on_edges, middles]), finer, numpy.repeat(groups, 4)


def rest():
    """The flat hand: points, triangles and the group of each triangle."""
    points, quads, groups = hull(*boxes())
    for _ in range(2):
        points, quads, groups = subdivided(points, quads, groups)
    # Of the two diagonals the shorter one.
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    other = numpy.linalg.norm(a - c, axis=1) > numpy.linalg.norm(b - d, axis=1)
    quads[other] = numpy.roll(quads[other], -1, axis=1)
    faces = numpy.stack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    return points, faces, numpy.repeat(groups, 2)


def smooth(t):
    t = numpy.clip(t, 0, 1)
    return t * t * (3 - 2 * t)


def bent(along, length, bends, share):
    """The middle of a bent finger at each place along it, from the knuckle on, and its direction there as an angle.

    The angle grows smoothly at each joint; the middle line is its integral (Simpson's rule, finely).
    """
    def angle(t):
        return sum(math.radians(bend * share) * smooth((t - joint) / SOFT + 0.5) for joint, bend in zip(JOINTS, bends))
    return *line_along(along, length, angle), angle(along)


def line_along(along, length, angle):
    """A line that begins along the first axis and has that angle at each place (0 to 1 and a bit), by Simpson's rule."""
    steps = numpy.linspace(0, 1.2, 1201)
    middle = (steps[:-1] + steps[1:]) / 2
    line = []
    for part in (numpy.cos, numpy.sin):
        pieces = (part(angle(steps[:-1])) + 4 * part(angle(middle)) + part(angle(steps[1:]))) / 6 * numpy.diff(steps)
        line.append(length * numpy.interp(along, steps, numpy.concatenate([[0], numpy.cumsum(pieces)])))
    return line


def posed(points, pose, share=1.0):
    """The points in a pose. Fingers bend as tubes do: no cross-section loses its shape."""
    made = points.copy()
    for n, finger in enumerate(FINGERS):
        if finger not in POSES[pose]:
            continue
        *bends, aside = POSES[pose][finger]
        low = n * (WIDTH + GAP)
        mine = (points[:, 1] > KNUCKLES) & (points[:, 0] > low - GAP / 2) & (points[:, 0] < low + WIDTH + GAP / 2)
        p = points[mine]
        along = (p[:, 1] - KNUCKLES) / LENGTH[finger]
        y, z, angle = bent(along, LENGTH[finger], bends, share)
        x, y = p[:, 0], KNUCKLES + y - p[:, 2] * numpy.sin(angle)
        z = z + p[:, 2] * numpy.cos(angle)
        turn = math.radians(aside * share) * smooth(along / SOFT)
        x, y = x - low - WIDTH / 2, y - KNUCKLES
        x, y = x * numpy.cos(turn) - y * numpy.sin(turn), x * numpy.sin(turn) + y * numpy.cos(turn)
        made[mine] = numpy.column_stack([x + low + WIDTH / 2, y + KNUCKLES, z])
    return made


def write(path, points, faces, groups):
    with open(path, "w", encoding="ascii") as file:
        file.writelines("v %r %r %r\n" % tuple(p) for p in points.tolist())
        for number, name in enumerate(GROUPS):
            file.write(f"g {name}\n")
            file.writelines("f %d %d %d\n" % tuple(f) for f in (faces[groups == number] + 1).tolist())


def hand(pose="fist"):
    """Points, triangles, and of each triangle its group, in a pose or (a number) on the way to a fist."""
    points, faces, groups = rest()
    if pose in POSES:
        return posed(points, pose), faces, groups
    return posed(points, "fist", float(pose)), faces, groups


def main():
    if not 2 <= len(sys.argv) <= 3 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    if os.path.splitext(sys.argv[1])[1].lower() != ".obj":
        sys.exit(f"{sys.argv[1]}: the name must end in .obj.")
    try:
        made = hand(*sys.argv[2:])
    except ValueError:
        sys.exit(f"{sys.argv[2]}: no such pose. Poses are {', '.join(POSES)}, or a number.")
    write(sys.argv[1], *made)


if __name__ == "__main__":
    main()
