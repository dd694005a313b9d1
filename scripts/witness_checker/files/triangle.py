"""What all formats do with a face."""

from ..errors import Unreadable


def triangle(corners):
    if len(corners) != 3:
        raise Unreadable("only triangles are read")
    return tuple(corners)
