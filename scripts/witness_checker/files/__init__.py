"""Surfaces as they stand in files: points as tuples of doubles, faces as tuples of three vertices."""

import math
import struct

from ..errors import Unreadable
from . import obj, off, ply, stl


def read_surface(path):
    """What a file begins with counts more than its name."""
    try:
        with open(path, "rb") as file:
            data = file.read()
        points, faces = format_of(data, path).read(data)
    except (OSError, ValueError, IndexError, KeyError, OverflowError, struct.error, Unreadable) as e:
        raise Unreadable(f"{path}: {e}") from e
    if not faces or not all(len(p) == 3 and all(map(math.isfinite, p)) for p in points):
        raise Unreadable(f"{path}: there are no faces, or a coordinate is not a number")
    if not all(0 <= v < len(points) for f in faces for v in f):
        raise Unreadable(f"{path}: a face names a vertex that does not exist")
    return points, faces


def format_of(data, path):
    if data[:4] in (b"ply\n", b"ply\r"):
        return ply
    if stl.is_binary(data) or data[:4096].split()[:1] == [b"solid"]:
        return stl
    return obj if path.lower().endswith(".obj") else off
