"""Tet meshes in MEDIT files, as the program writes them."""

from .errors import Unreadable


def read_mesh(path):
    """Points and tets, counted from 0."""
    try:
        with open(path, encoding="ascii") as file:
            words = file.read().split()
        return section(words, "Vertices", 3, float), [
            tuple(v - 1 for v in t) for t in section(words, "Tetrahedra", 4, int)
        ]
    except (OSError, ValueError, IndexError) as e:
        raise Unreadable(f"{path}: {e}") from e


def section(words, name, width, number):
    """The rows of a section, without the label behind each."""
    at = words.index(name) + 2
    count = int(words[at - 1])
    rows = [words[i : i + width] for i in range(at, at + count * (width + 1), width + 1)]
    if rows and len(rows[-1]) < width:
        raise ValueError("the file ends too early")
    return [tuple(map(number, row)) for row in rows]


def mesh_text(points, tets):
    lines = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(points))]
    lines += [" ".join(map(repr, map(float, p))) + " 0" for p in points] + ["Tetrahedra", str(len(tets))]
    lines += [" ".join(str(v + 1) for v in t) + " 0" for t in tets] + ["End"]
    return "\n".join(lines) + "\n"
