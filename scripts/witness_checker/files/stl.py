"""STL, as text and binary: triangles with corners of their own."""

import struct

from ..errors import Unreadable


def is_binary(data):
    return len(data) >= 84 and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little")


def read(data):
    """Equal corners are one vertex; vertices are numbered as they first appear."""
    if is_binary(data):
        corners = [
            struct.unpack_from("<3f", data, 84 + 50 * t + 12 * k)
            for t in range((len(data) - 84) // 50)
            for k in (1, 2, 3)
        ]
    else:
        lines = (line.split() for line in data.decode(errors="replace").splitlines())
        corners = [tuple(map(float, words[1:4])) for words in lines if words[:1] in (["vertex"], ["VERTEX"])]
    number = {}
    ids = [number.setdefault(tuple(x + 0.0 for x in c), len(number)) for c in corners]
    if len(ids) % 3:
        raise Unreadable("the file ends inside a triangle")
    return list(number), [tuple(ids[i : i + 3]) for i in range(0, len(ids), 3)]
