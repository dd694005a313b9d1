"""Models that have a mesh by construction: surfaces of tets in integers that overlap. No answer but a mesh is right."""

from ..complex import Solid
from ..errors import NoModel
from ..growth import Growth, grow, one_tet, random_point, shake, spin, weld

MOST = 1 << 40  # coordinates stay below it, so that they are doubles with room to spare

# A cube in six tets around a diagonal: cubes that are moved copies of each other agree on their squares.
PATHS = ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0))


def grown(rng):
    """Tets on tets, with room between the numbers."""
    growth = one_tet(rng, 1000)
    grow(growth, rng, rng.randint(12, 70), 1200)
    return growth.solid()


def lattice(rng):
    """The same in a box of few numbers, so that much touches and coincides."""
    size = rng.randint(2, 6)
    growth = one_tet(rng, size)
    grow(growth, rng, rng.randint(10, 50), size)
    return growth.solid()


def tunnels(rng):
    """Growth that bites its own tail: handles."""
    growth = one_tet(rng, 1000)
    grow(growth, rng, rng.randint(25, 60), 1000, 0.3)
    return growth.solid()


def fan(rng):
    """Tets around an edge, by one turn or several, so that the edge is wound; with other such edges, and growth."""
    size = rng.choice((4, 30, 1000))
    growth = one_tet(rng, size)
    for _ in range(rng.randint(1, 3)):
        a, b = rng.choice(sorted(growth.across))
        spin(growth, rng, a, b, rng.randint(4, 14), 2 * size)
    grow(growth, rng, len(growth.tets) + rng.randint(0, 12), size)
    return growth.solid()


def cubes(cells, glued, scale):
    """Cubes that share the corners that they have in common with the cube that they are glued to, and no others: each
    is glued to one before it, at a square."""
    points, tets, corners = [], [], []
    for cell, to in zip(cells, glued):
        mine = {}
        for x in (0, 1):
            for y in (0, 1):
                for z in (0, 1):
                    place = (cell[0] + x, cell[1] + y, cell[2] + z)
                    known = corners[to].get(place) if to is not None else None
                    if known is None:
                        known = len(points)
                        points.append(tuple(scale * c for c in place))
                    mine[place] = known
        corners.append(mine)
        for path in PATHS:
            at, tet = list(cell), [mine[tuple(cell)]]
            for k in path:
                at[k] += 1
                tet.append(mine[tuple(at)])
            odd = path in ((0, 2, 1), (1, 0, 2), (2, 1, 0))
            tets.append((tet[1], tet[0], tet[2], tet[3]) if odd else tuple(tet))
    return Growth(points, tets)


def chain_of_cubes(rng, most, scale):
    """A walk with branches. Where it comes back to a place it has been to, cubes lie in each other; where it passes by
    a place, squares lie on each other unglued."""
    cells, glued, free = [(0, 0, 0)], [None], [{0, 1, 2, 3, 4, 5}]
    for _ in range(rng.randint(4, most)):
        to = len(cells) - 1 if rng.random() < 0.85 else rng.randrange(len(cells))
        if not free[to]:
            continue
        side = rng.choice(sorted(free[to]))
        free[to].remove(side)
        free.append({0, 1, 2, 3, 4, 5} - {side ^ 1})
        step = (1 if side % 2 else -1)
        cells.append(tuple(c + step * (k == side // 2) for k, c in enumerate(cells[to])))
        glued.append(to)
    if len(set(cells)) == len(cells):
        raise NoModel  # no cube lies in another
    return cubes(cells, glued, scale)


def blocks(rng):
    """Cubes in places where cubes are, or beside them and not glued: coincident faces, slits, wound edges."""
    return chain_of_cubes(rng, 10, 1).solid()


def shaken(rng):
    """Chains of cubes, their vertices moved at random as long as all tets are positive."""
    growth = chain_of_cubes(rng, 9, 100)
    shake(growth, rng, rng.choice((20, 200, 1000)), rng.choice((30, 150, 400)))
    return growth.solid()


def cake(rng):
    """A flat bar that is folded: square by square its layers come to lie in each other or cross at an angle."""
    n = rng.randint(3, 7)
    growth = cubes([(i, 0, 0) for i in range(n)], [None, *range(n - 1)], 1000)
    for _ in range(rng.randint(1, 2)):
        fold(growth, rng, 1000 * rng.randint(1, n - 1), 1000 * n)
    if rng.random() < 0.5:
        weld(growth, rng, 60)
    return growth.solid()


def fold(growth, rng, at, length):
    """Draws all that is beyond a plane towards its image in a turn by half around an axis in the bar's top, in steps that
    keep tets positive."""
    order = [v for v, p in enumerate(growth.points) if p[0] > at]
    thick = rng.choice((200, 700, 1000))
    goals = {v: (2 * at - p[0], thick - p[1] if rng.random() < 0.9 else -p[1], p[2] + rng.choice((0, 0, 150)))
             for v, p in enumerate(growth.points) if p[0] > at}
    for _ in range(60):
        for v in order:
            p = growth.points[v]
            for part in (1, 2, 4, 8):
                target = [x + (g - x) // part for x, g in zip(p, goals[v])]
                # Sideways, too: by itself no vertex gets past the hinge.
                if part > 1:
                    target = random_point(rng, length // (8 * part), target)
                if growth.move(v, target):
                    break


def welded(rng):
    """Growth whose vertices are moved onto others, onto middles and into planes."""
    growth = one_tet(rng, 64)
    grow(growth, rng, rng.randint(10, 40), 80)
    weld(growth, rng, rng.choice((50, 300)))
    return growth.solid()


SMALL = (grown, lattice, fan, blocks, welded)


def copies(rng):
    """Two or three models at once: copies in one place, or moved a little; or different ones."""
    one = rng.choice(SMALL)(rng)
    if len(one.tets) > 40:
        raise NoModel
    points, tets = [], []
    for i in range(rng.choice((2, 2, 3))):
        part = one if rng.random() < 0.8 else rng.choice(SMALL)(rng)
        reach = rng.choice((0, 0, 1, 50))
        move = random_point(rng, reach) if i else (0, 0, 0)
        tets += [tuple(v + len(points) for v in t) for t in part.tets]
        points += [tuple(x + m for x, m in zip(p, move)) for p in part.points]
    return Solid(points, tets)


def image(solid, matrix, move):
    points = [tuple(sum(m * x for m, x in zip(row, p)) + d for row, d in zip(matrix, move)) for p in solid.points]
    if max(abs(x) for p in points for x in p) > MOST:
        raise NoModel
    return Solid(points, solid.tets)


def needles(rng):
    """Models that are drawn out in one direction and sheared, by large factors."""
    a, b = (rng.randint(-(10**4), 10**4) for _ in range(2))
    matrix = [(rng.choice((1, 10, 10**4)), a, b), (0, 1, rng.randint(-20, 20)), (0, 0, 1)]
    k = rng.randrange(3)  # the direction
    return image(rng.choice(SMALL)(rng), matrix[k:] + matrix[:k], (0, 0, 0))


def affine(rng):
    """Images under matrices of random integers, far from the origin."""
    size = rng.choice((3, 1000, 10**6))
    matrix = [random_point(rng, size) for _ in range(3)]
    (a, b, c), (d, e, f), (g, h, i) = matrix
    if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) <= 0:
        raise NoModel
    return image(rng.choice(SMALL)(rng), matrix, random_point(rng, rng.choice((0, 10**9, 10**11))))
