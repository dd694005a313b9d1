"""What all formats do with a face."""

from ..errors import Unreadable


def triangle(corners):
    if len(corners) != 3:
        raise Unreadable("a face is not a triangle")
    return tuple(corners)
