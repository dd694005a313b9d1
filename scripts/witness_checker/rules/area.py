"""Rule `area`: a face whose corners lie on one line.

{"rule": "area", "face": f, "vertices": [a, b, c]}

No tet with volume can have it as a face.
"""

from ..errors import Refuted, Unreadable
from ..fields import whole_number, whole_numbers


def check(surface, witness):
    f, vertices = whole_number(witness, "face"), whole_numbers(witness, "vertices")
    if not 0 <= f < len(surface.faces):
        raise Unreadable(f"the surface has no face {f}")
    if sorted(surface.faces[f]) != sorted(vertices):
        raise Refuted(f"the witness does not name the corners of face {f}")
    if tuple(surface.normal(f)) != (0, 0, 0):
        raise Refuted(f"face {f} has an area")
    return f"face {f} has no area"
