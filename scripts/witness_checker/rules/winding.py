"""Rule `winding`: a point around which the winding number is negative.

{"point": [x, y, z], "winding": w}

A tet mesh covers a point next to which the winding number is w just w times; tets turned inside out would count -1, and
there are none.
"""

from ..errors import Refuted
from ..fields import point_of, whole_number
from ..geometry.winding import winding


def check(surface, witness):
    numerator, w = point_of(surface, witness, "point")
    claimed = whole_number(witness, "winding")
    value, _ = winding(surface, numerator, w)
    if value >= 0:
        raise Refuted(f"the winding number of the point is {value}")
    if value != claimed:
        raise Refuted(f"the winding number of the point is {value}, not {claimed}")
    return f"the surface winds around the point {value} times"
