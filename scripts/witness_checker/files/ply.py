"""PLY, as text and binary in both byte orders."""

import struct

from ..errors import Unreadable
from .triangle import triangle

TYPES = {
    **dict.fromkeys(("char", "int8"), "b"), **dict.fromkeys(("uchar", "uint8"), "B"),
    **dict.fromkeys(("short", "int16"), "h"), **dict.fromkeys(("ushort", "uint16"), "H"),
    **dict.fromkeys(("int", "int32"), "i"), **dict.fromkeys(("uint", "uint32"), "I"),
    **dict.fromkeys(("float", "float32"), "f"), **dict.fromkeys(("double", "float64"), "d"),
}  # fmt: skip


def read(data):
    head, _, body = data.partition(b"end_header")
    body = body[body.index(b"\n") + 1 :]
    kind, elements = read_head(head)
    take = words_of(body) if kind == "ascii" else bytes_of(body, "<" if kind == "binary_little_endian" else ">")
    points, faces = [], []
    for name, count, properties in elements:
        for _ in range(count):
            item = {}
            for key, size, letter in properties:
                item[key] = take(letter) if size is None else [take(letter) for _ in range(int(take(size)))]
            if name == "vertex":
                points.append((float(item["x"]), float(item["y"]), float(item["z"])))
            elif name == "face":
                corners = item.get("vertex_indices", item.get("vertex_index"))
                faces.append(triangle([int(c) for c in corners or []]))
    return points, faces


def read_head(head):
    """The kind of file, and its elements: [name, count, [(name, type of a list's count or None, type)]]."""
    kind, elements = None, []
    for words in (line.split() for line in head.decode("latin1").splitlines()):
        if words[:1] == ["format"]:
            kind = words[1]
        elif words[:1] == ["element"]:
            elements.append([words[1], int(words[2]), []])
        elif words[:1] == ["property"]:
            size = TYPES[words[2]] if words[1] == "list" else None
            elements[-1][2].append((words[-1], size, TYPES[words[-2]]))
    return kind, elements


def words_of(body):
    """A function that takes the next number of a text."""
    tokens = iter(body.split())

    def take(letter):
        word = next(tokens, None)
        if word is None:
            raise Unreadable("the file ends too early")
        value = float(word)
        # What is called float holds floats, however it is written.
        return struct.unpack("f", struct.pack("f", value))[0] if letter == "f" else value

    return take


def bytes_of(body, order):
    """A function that takes the next number of a binary file."""
    at = 0

    def take(letter):
        nonlocal at
        item = struct.Struct(order + letter)
        if at + item.size > len(body):
            raise Unreadable("the file ends too early")
        (value,) = item.unpack_from(body, at)
        at += item.size
        return value

    return take
