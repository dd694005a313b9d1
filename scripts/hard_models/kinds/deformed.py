"""Models that come from deforming simple surfaces, as animation and scanning do. Some have a mesh, others have none."""

import math

from ..seeds import on_grid
from ..surface import Surface
from . import shapes
from ..collapse import collapse_to


def moved(surface, place):
    return Surface(on_grid([place(p) for p in surface.points]), surface.faces)


def bend(rng):
    """Long ones, bent along a curve by a large angle, twisted and climbing by random amounts."""
    surface = rng.choice((shapes.slab, shapes.tube, shapes.capsule))(rng)
    frames = spine(rng, sorted({p[0] for p in surface.points}))

    def place(p):
        middle, _, across, up = frames[p[0]]
        return [m + p[1] * a + p[2] * u for m, a, u in zip(middle, across, up)]

    return moved(surface, place)


def spine(rng, places):
    """x -> the point of a random curve there, with a frame. The curve bends by 1 to 3 parts of constant curvature."""
    length = places[-1] - places[0]
    total = rng.uniform(math.pi, 4 * math.pi) / length
    parts = []
    for _ in range(rng.randint(1, 3)):
        curvature = rng.uniform(0.3, 1.7) * rng.choice((1, 1, 1, -1))
        parts.append((curvature * total, rng.choice((0, 0, rng.uniform(-0.3, 0.3))) * total))
    frame = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    out = {}
    before = places[0]
    for x in places:
        steps = max(1, math.ceil((x - before) / length * 100))
        for i in range(steps if x > before else 0):
            at = before + (i + 0.5) * (x - before) / steps
            curvature, torsion = parts[min(len(parts) - 1, int((at - places[0]) / length * len(parts)))]
            frame = advance(frame, (x - before) / steps, curvature, torsion)
        out[x] = frame
        before = x
    return out


def advance(frame, step, curvature, torsion):
    middle, along, across, up = frame
    middle = [m + step * a for m, a in zip(middle, along)]
    along, across = rotated(along, across, step * curvature)
    across, up = rotated(across, up, step * torsion)
    return middle, along, across, up


def rotated(a, b, angle):
    """Two directions, turned in their plane."""
    c, s = math.cos(angle), math.sin(angle)
    return [c * x + s * y for x, y in zip(a, b)], [c * y - s * x for x, y in zip(a, b)]


def poke(rng):
    """Patches pushed through the opposite side, or pulled out and into another part of the surface from outside."""
    surface = rng.choice((*shapes.ALL, shapes.torus, bend))(rng)
    points = [list(p) for p in surface.points]
    for _ in range(rng.randint(1, 3)):
        start = rng.randrange(len(points))
        way = way_out(rng, surface, start) if rng.random() < 0.6 else None
        if way is None:
            way = way_in(rng, surface, start)
        reach = rng.randint(0, 3)
        for v, rings in nearby(surface, start, reach).items():
            for k in range(3):
                points[v][k] += (1 - rings / (reach + 1)) * way[k]
    return Surface(on_grid(points), surface.faces)


def way_in(rng, surface, start):
    """Against the outwards direction, by about as much as there is of the surface there."""
    inwards = [-x for x in outwards(surface, start)]
    depth = max(dot(inwards, difference(p, surface.points[start])) for p in surface.points)
    return [depth * rng.uniform(0.7, 1.6) * (x + rng.uniform(-0.2, 0.2)) for x in inwards]


def way_out(rng, surface, start):
    """Through a vertex in front of this one that faces it; None if none is found."""
    out = outwards(surface, start)
    for _ in range(20):
        target = rng.randrange(len(surface.points))
        way = difference(surface.points[target], surface.points[start])
        if dot(way, out) > 0 and dot(way, outwards(surface, target)) < 0:
            return [x * rng.uniform(1.05, 1.4) for x in way]
    return None


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def difference(a, b):
    return [x - y for x, y in zip(a, b)]


def outwards(surface, v):
    total = [0.0, 0.0, 0.0]
    for f in surface.faces:
        if v in f:
            a, b, c = (surface.points[x] for x in f)
            u, w = difference(b, a), difference(c, a)
            for k in range(3):
                total[k] += u[(k + 1) % 3] * w[(k + 2) % 3] - u[(k + 2) % 3] * w[(k + 1) % 3]
    length = math.sqrt(dot(total, total))
    return [x / length for x in total] if length > 0 else [0.0, 0.0, 1.0]


def nearby(surface, start, reach):
    """Vertices by the number of edges to them."""
    neighbours = {}
    for f in surface.faces:
        for k in range(3):
            neighbours.setdefault(f[k], set()).add(f[k - 1])
            neighbours.setdefault(f[k - 1], set()).add(f[k])
    out, ring = {start: 0}, [start]
    for i in range(reach):
        ring = sorted({w for v in ring for w in neighbours[v]} - out.keys())
        out.update({w: i + 1 for w in ring})
    return out


def pose(rng):
    """A creature with limbs of two bones each, bent strongly at both joints; skin follows bones by linear blending."""
    limbs = {side: rng.randint(2, 4) for side in range(6) if rng.random() < 0.6}
    if not limbs:
        limbs = {1: 4}
    body = rng.randint(1, 2)
    surface = shapes.creature(limbs, body)
    for _ in range(rng.randint(0, 2)):
        surface = shapes.smoothed(surface)
    bones = {side: joints(rng, side, length, body) for side, length in limbs.items()}

    def place(p):
        for side, (first, second) in bones.items():
            if shapes.along(p, side, body) > 0:
                lower = second(p)
                return first(lower)
        return p

    return moved(surface, place)


def joints(rng, side, length, body):
    """The maps of the bone at the body and of the outer one."""
    strong = math.pi * rng.uniform(0.15, 0.8)
    return (joint(rng, side, body, 0.3, strong * rng.choice((-1, 1)), rng.uniform(0.2, 1.0)),
            joint(rng, side, body, length / 2, strong * rng.choice((-1, 1)), rng.uniform(0.2, 1.0)))


def joint(rng, side, body, at, angle, width):
    axis = side // 2
    other, third = (axis + 1) % 3, (axis + 2) % 3
    if rng.random() < 0.5:
        other, third = third, other
    sign = 1 if side % 2 else -1

    def place(p):
        x = shapes.along(p, side, body) - at
        weight = min(1.0, max(0.0, 0.5 + x / width))
        c, s = math.cos(angle), math.sin(angle)
        turned = list(p)
        height = p[other] - 0.5
        turned[axis] = p[axis] + sign * ((c - 1) * x - s * height)
        turned[other] = 0.5 + s * x + c * height
        return [(1 - weight) * a + weight * b for a, b in zip(p, turned)]

    return place


def wave(rng):
    """Any surface with waves or with noise that are larger than it is thick."""
    surface = rng.choice(shapes.ALL)(rng)
    size = rng.uniform(0.05, 0.5)
    if rng.random() < 0.4:
        return moved(surface, lambda p: [x + size * rng.uniform(-1, 1) for x in p])
    waves = [([rng.uniform(-5, 5) for _ in range(3)], rng.uniform(0, 6), rng.randrange(3)) for _ in range(4)]

    def place(p):
        out = list(p)
        for direction, phase, k in waves:
            out[k] += size * math.sin(phase + dot(direction, p))
        return out

    return moved(surface, place)


def decimate(rng):
    """A deformed surface, its edges collapsed until a part of it is left."""
    surface = rng.choice((bend, poke, pose, wave))(rng)
    return collapse_to(surface, max(8, int(len(surface.faces) * rng.uniform(0.1, 0.5))))


def scale(rng):
    """A deformed surface, huge, tiny, drawn out in one direction or far away."""
    surface = rng.choice((bend, poke, pose, wave))(rng)
    surface = collapse_to(surface, max(8, len(surface.faces) // 2))
    # The program's limits are 1e-72 and 1e72.
    factors = [rng.choice((1e-60, 1e-30, 1e-9, 2.0**-40, 1.0, 3.0, 2.0**40, 1e9, 1e30, 1e60))] * 3
    if rng.random() < 0.3:
        factors[rng.randrange(3)] *= rng.choice((1e-3, 1e3))
    far = rng.choice((0.0, 0.0, 10.0, 1e3, 1e6))
    return Surface([tuple((x + far) * f for x, f in zip(p, factors)) for p in surface.points], surface.faces)
