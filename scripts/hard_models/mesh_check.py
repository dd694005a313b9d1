"""Whether a tet mesh is what the program promises, in integers and without the program."""

import struct

from .complex import boundary, faults, turned
from .exact import integers


def bits(points):
    return [struct.pack("<3d", *p) for p in points]


def mesh_faults(surface, points, tets, moved=None):
    """Why this is not a mesh of the surface; "" if it is one. `moved`: vertices that need not be where they were."""
    n = len(surface.points)
    if len(points) < n:
        return f"the mesh has {len(points)} vertices, the surface {n}"
    before, after = bits(surface.points), bits(points[:n])
    for v in range(n):
        if before[v] != after[v] and v not in (moved or ()):
            return f"vertex {v} has moved"
    if any(not 0 <= v < len(points) for t in tets for v in t):
        return "a tet names a vertex that does not exist"
    wanted, found = {turned(f) for f in surface.faces}, set(boundary(tets))
    if wanted != found:
        lost, more = sorted(wanted - found), sorted(found - wanted)
        return f"face {lost[0]} is no boundary face" if lost else f"the boundary face {more[0]} is no face of the surface"
    return faults(integers(points), tets)
