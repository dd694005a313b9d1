"""OFF: points and triangles as text."""

from ..errors import Unreadable
from .triangle import triangle


def read(data):
    lines = [line.split() for line in (x.split("#")[0] for x in data.decode(errors="replace").splitlines())]
    lines = [words for words in lines if words]
    if not lines or lines[0][0] not in ("OFF", "COFF", "STOFF", "STCOFF", "NOFF"):
        raise Unreadable("this variant of OFF is not supported")
    first = lines[0][1:] or lines[1]
    at = 1 if lines[0][1:] else 2
    n, m = int(first[0]), int(first[1])
    if len(lines) < at + n + m:
        raise Unreadable("the file ends too early")
    # Colours and the like stand behind what counts.
    points = [tuple(map(float, words[:3])) for words in lines[at : at + n]]
    faces = [triangle([int(x) for x in words[1 : 1 + int(words[0])]]) for words in lines[at + n : at + n + m]]
    return points, faces
