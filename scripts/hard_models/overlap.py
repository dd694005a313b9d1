"""Whether a surface passes through itself, as far as two quick looks see it."""

from .exact import volume


def overlaps(solid):
    """Whether the middle of one tet lies in another, or an edge of the boundary goes through a face of it."""
    return any_middle_inside(solid) or any_edge_through(solid.points, solid.surface.faces)


def any_middle_inside(solid):
    corners = [[tuple(4 * x for x in solid.points[v]) for v in t] for t in solid.tets]
    boxes = [box(c) for c in corners]
    middles = [tuple(sum(p[k] for p in c) // 4 for k in range(3)) for c in corners]
    for i, m in enumerate(middles):
        for j, (low, high) in enumerate(boxes):
            if i != j and all(low[k] < m[k] < high[k] for k in range(3)) and inside(m, corners[j]):
                return True
    return False


def inside(p, tet):
    a, b, c, d = tet
    return volume(p, b, c, d) > 0 and volume(a, p, c, d) > 0 and volume(a, b, p, d) > 0 and volume(a, b, c, p) > 0


def any_edge_through(points, faces):
    boxes = [box([points[v] for v in f]) for f in faces]
    edges = sorted({tuple(sorted((f[k], f[k - 1]))) for f in faces for k in range(3)})
    for e in edges:
        a, b = (points[v] for v in e)
        low, high = box([a, b])
        for f, (f_low, f_high) in zip(faces, boxes):
            apart = any(low[k] > f_high[k] or high[k] < f_low[k] for k in range(3))
            if not apart and not set(e) & set(f) and goes_through(a, b, *(points[v] for v in f)):
                return True
    return False


def goes_through(a, b, x, y, z):
    up, down = volume(x, y, z, a), volume(x, y, z, b)
    if up * down >= 0:
        return False
    signs = [volume(a, b, x, y) > 0, volume(a, b, y, z) > 0, volume(a, b, z, x) > 0]
    return all(signs) or (not any(signs) and 0 not in (volume(a, b, x, y), volume(a, b, y, z), volume(a, b, z, x)))


def box(points):
    return tuple(map(min, zip(*points))), tuple(map(max, zip(*points)))
