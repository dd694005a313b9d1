"""Histograms of triangle areas, as under the paper's figures 7 and 15: V0 of the input, V_t* at the end of the forward flow,
U0 at the end of the reverse flow. One SVG a model."""
import html
import os

import numpy as np

BINS, LOW, HIGH = 60, -6.0, 1.5  # of the decimal logarithm of area over the mean area of V0; what lies outside is put at the ends
PLOT, LEFT, TOP, HEIGHT, GAP = 320, 30, 44, 110, 24
COLOURS = ("#4477aa", "#ee6677", "#228833")


def read_ply(path):
    """Vertices (#V x 3) and faces (#F x 3) of a binary little-endian PLY as the program writes it."""
    with open(path, "rb") as f:
        data = f.read()
    head, _, body = data.partition(b"end_header\n")
    lines = head.decode("ascii").splitlines()
    if "format binary_little_endian 1.0" not in lines:
        raise ValueError(f"{path}: not a binary PLY of this machine's byte order")
    count = {words[1]: int(words[2]) for words in map(str.split, lines) if words[:1] == ["element"]}
    vertices = np.frombuffer(body, "<f8", 3 * count["vertex"]).reshape(-1, 3)
    face = np.dtype([("n", "u1"), ("v", "<i4", 3)])
    return vertices, np.frombuffer(body, face, count["face"], vertices.nbytes)["v"]


def areas(vertices, faces):
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def shares(area, mean):
    """The share of the faces in each bin."""
    with np.errstate(divide="ignore"):
        logs = np.clip(np.log10(area / mean), LOW, np.nextafter(HIGH, LOW))
    return np.histogram(logs, BINS, (LOW, HIGH))[0] / len(area)


def svg(title, states):
    """states: name and areas of the faces, V0 first."""
    mean = states[0][1].mean()
    found = [shares(area, mean) for _, area in states]
    most = max(s.max() for s in found)
    width, height = LEFT + PLOT + 12, TOP + len(states) * (HEIGHT + GAP) + 22
    step = PLOT / BINS
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
           f'font-family="sans-serif" font-size="11" role="img" aria-label="Histograms of triangle areas: {html.escape(title)}">',
           f'<rect width="{width}" height="{height}" fill="white"/>',
           f'<text x="{LEFT}" y="18" font-size="13">{html.escape(title)}</text>',
           f'<text x="{LEFT}" y="33" fill="#555">share of faces by area over the mean of V0</text>']
    for i, ((name, area), share) in enumerate(zip(states, found)):
        base = TOP + GAP * i + HEIGHT * (i + 1)
        small, middle = np.percentile(area / mean, (1, 50))
        out.append(f'<text x="{LEFT}" y="{base - HEIGHT + 10}">{html.escape(name)}: 1 % of the faces below {small:.2g}, '
                   f'half below {middle:.2g}</text>')
        for k, s in enumerate(share):
            if s > 0:
                h = s / most * (HEIGHT - 18)
                out.append(f'<rect x="{LEFT + k * step:.2f}" y="{base - h:.2f}" width="{step:.2f}" height="{h:.2f}" '
                           f'fill="{COLOURS[i % len(COLOURS)]}"/>')
        out.append(f'<line x1="{LEFT}" y1="{base}" x2="{LEFT + PLOT}" y2="{base}" stroke="#555"/>')
    below = TOP + len(states) * (HEIGHT + GAP) - GAP + 14
    for power in range(int(np.ceil(LOW)), int(HIGH) + 1):
        x = LEFT + (power - LOW) / (HIGH - LOW) * PLOT
        out.append(f'<text x="{x:.1f}" y="{below}" text-anchor="middle">1e{power}</text>')
    return "\n".join(out + ["</svg>", ""])


def write(title, model_surface, stages, path):
    """False if the run has no end of its forward flow: nothing was in the way, or it has several parts."""
    ends = [os.path.join(stages, name) for name in ("flow_end.ply", "embedded.ply")]
    if not all(map(os.path.exists, ends)):
        return False
    states = [("V0", areas(*model_surface))]
    states += [(name, areas(*read_ply(end))) for name, end in zip(("V_t*", "U0"), ends)]
    with open(path, "w", encoding="utf-8") as f:
        f.write(svg(title, states))
    return True
