"""Simple closed surfaces of a hundred faces or a few more, long ones along x."""

import math

from ..surface import Surface


def of_polygons(points, polygons):
    """A surface from polygons in any hashable corners; triangles as fans, points in order of first use."""
    number, faces = {}, []
    for corners in polygons:
        ids = [number.setdefault(c, len(number)) for c in corners]
        faces += [(ids[0], ids[i], ids[i + 1]) for i in range(1, len(ids) - 1)]
    return Surface([points[c] for c in number], faces)


def box_of(counts, sizes):
    """A box around the origin in x, y, z, so many squares along each side."""
    places, polygons = {}, []
    for k in range(3):
        u, v = (k + 1) % 3, (k + 2) % 3
        for end in (0, counts[k]):
            for i in range(counts[u]):
                for j in range(counts[v]):
                    square = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        c = [0, 0, 0]
                        c[k], c[u], c[v] = end, i + di, j + dj
                        square.append(tuple(c))
                    polygons.append(square if end else square[::-1])
    for square in polygons:
        for c in square:
            places[c] = tuple(sizes[k] * (c[k] / counts[k] - 0.5) for k in range(3))
    return of_polygons(places, polygons)


def box(rng):
    return box_of([rng.randint(2, 5) for _ in range(3)], [rng.uniform(0.5, 1.5) for _ in range(3)])


def slab(rng):
    """Long, and thin or square."""
    counts = [rng.randint(12, 30), rng.randint(1, 4), 1]
    return box_of(counts, [rng.uniform(4, 8), rng.uniform(0.4, 1.5), rng.uniform(0.1, 0.8)])


def rings_of(rings, around, closed):
    """Rings (x, radius) around x, joined one to the next. Closed: the last to the first; else to a point at both ends."""
    points, polygons = {}, []
    for i, (x, radius) in enumerate(rings):
        for j in range(around):
            angle = 2 * math.pi * j / around
            points[i, j] = (x, radius * math.cos(angle), radius * math.sin(angle))
    n = len(rings)
    for i in range(n if closed else n - 1):
        for j in range(around):
            polygons.append([(i, j), (i, (j + 1) % around), ((i + 1) % n, (j + 1) % around), ((i + 1) % n, j)])
    return points, polygons


def with_ends(rings, around, first, last):
    points, polygons = rings_of(rings, around, False)
    points["first"], points["last"] = (first, 0.0, 0.0), (last, 0.0, 0.0)
    for j in range(around):
        k = (j + 1) % around
        polygons += [["first", (0, k), (0, j)], ["last", (len(rings) - 1, j), (len(rings) - 1, k)]]
    return of_polygons(points, polygons)


def cap(radius, count):
    """(distance from the middle of a half ball, radius) of its rings, from the wide end on."""
    angles = [math.pi / 2 * i / count for i in range(count)]
    return [(radius * math.sin(a), radius * math.cos(a)) for a in angles]


def sphere(rng):
    return capsule_of(0.0, 1.0, 1, rng.randint(6, 14))


def capsule_of(length, radius, count, around):
    ends = cap(radius, max(2, around // 4))
    rings = [(-x, r) for x, r in reversed(ends)]
    if length > 0:
        rings += [(length * i / count, radius) for i in range(1, count)] + [(length, radius)]
    rings += [(length + x, r) for x, r in ends[1:]]
    return with_ends(rings, around, -radius, length + radius)


def capsule(rng):
    return capsule_of(rng.uniform(3, 8), rng.uniform(0.3, 1.0), rng.randint(8, 20), rng.randint(5, 9))


def tube(rng):
    """A pipe with a wall."""
    length, outer, count = rng.uniform(3, 8), rng.uniform(0.3, 0.8), rng.randint(8, 20)
    inner = outer * rng.uniform(0.3, 0.9)
    rings = [(length * i / count, outer) for i in range(count + 1)]
    rings += [(length * i / count, inner) for i in range(count, -1, -1)]
    points, polygons = rings_of(rings, rng.randint(4, 7), True)
    return of_polygons(points, polygons)


def torus(rng):
    count, thick = rng.randint(6, 10), rng.uniform(0.2, 0.7)
    angles = [2 * math.pi * i / count for i in range(count)]
    rings = [(thick * math.sin(a), 1 - thick * math.cos(a)) for a in angles]
    points, polygons = rings_of(rings[::-1], rng.randint(8, 16), True)
    return of_polygons(points, polygons)


ALL = (sphere, torus, box, capsule, slab, tube)


def along(p, side, body):
    """How far a point is out on the limb of a creature's side; negative elsewhere."""
    x = p[side // 2]
    low, high = (0, body) if side // 2 == 0 else (0, 1)
    out = x - high if side % 2 else low - x
    others = [p[k] for k in range(3) if k != side // 2]
    # The limbs of the sides of x have no others beside them.
    return out if all(-0.5 < y < 1.5 for y in others) or side // 2 == 0 else -1.0


def creature(limbs, body):
    """Unit cubes: a body of one or two along x, and for sides of it rows of cubes. Each square in eight faces."""
    cells = {(i, 0, 0) for i in range(body)}
    for side, length in limbs.items():
        for i in range(1, length + 1):
            cell = [0, 0, 0]
            cell[side // 2] = (body - 1 if side == 1 else 0) + (i if side % 2 else -i)
            cells.add(tuple(cell))
    polygons = []
    for cell in sorted(cells):
        for k in range(3):
            for end in (0, 1):
                beyond = list(cell)
                beyond[k] += 1 if end else -1
                if tuple(beyond) not in cells:
                    polygons += quarters(cell, k, end)
    return of_polygons({c: tuple(x / 2 for x in c) for square in polygons for c in square}, polygons)


def quarters(cell, k, end):
    """A square of a cell in four, in half units."""
    u, v = (k + 1) % 3, (k + 2) % 3
    out = []
    for i in (0, 1):
        for j in (0, 1):
            square = []
            for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                c = [2 * x for x in cell]
                c[k] += 2 * end
                c[u] += i + di
                c[v] += j + dj
                square.append(tuple(c))
            out.append(square if end else square[::-1])
    return out


def smoothed(surface):
    """Every vertex half-way to the middle of its neighbours."""
    sums = [[0.0, 0.0, 0.0, 0] for _ in surface.points]
    for f in surface.faces:
        for k in range(3):
            for i in range(3):
                sums[f[k]][i] += surface.points[f[k - 1]][i]
            sums[f[k]][3] += 1
    points = [tuple((x + s[i] / s[3]) / 2 for i, x in enumerate(p)) for p, s in zip(surface.points, sums)]
    return Surface(points, surface.faces)
