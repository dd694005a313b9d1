"""Surfaces for the examples: numpy arrays, made by formulas."""
import numpy as np


def figure_eight(along=96, around=16, radius=.3):
    """A closed tube along a figure eight: it passes through itself where the strands cross. V, F."""
    t = np.linspace(0, 2 * np.pi, along, endpoint=False)
    centre = np.stack([2 * np.sin(t), np.sin(2 * t), .1 * np.cos(t)], axis=1)
    tangent = np.stack([2 * np.cos(t), 2 * np.cos(2 * t), -.1 * np.sin(t)], axis=1)
    side = np.cross([0, 0, 1], tangent)
    side /= np.linalg.norm(side, axis=1)[:, None]
    up = np.cross(tangent, side)
    up /= np.linalg.norm(up, axis=1)[:, None]
    a = np.linspace(0, 2 * np.pi, around, endpoint=False)[None, :, None]
    V = centre[:, None] + radius * (np.cos(a) * side[:, None] + np.sin(a) * up[:, None])
    i, j = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")

    def at(k, m):
        return (k % along) * around + m % around
    F = np.stack([at(i, j), at(i, j + 1), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)], axis=-1)
    return V.reshape(-1, 3), F.reshape(-1, 3)


def dented_ball(depth=1.05, around=16, rings=8):
    """A ball whose north pole was pushed through the south pole, a little: it has no tet mesh. V, F."""
    a, b = np.meshgrid(np.pi * np.arange(1, rings) / rings, 2 * np.pi * np.arange(around) / around, indexing="ij")
    sphere = np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)], axis=-1).reshape(-1, 3)
    V = np.vstack([[0, 0, -depth], sphere, [0, 0, -1]])
    F = []
    for j in range(around):
        k = (j + 1) % around
        F.append((0, 1 + j, 1 + k))
        for i in range(rings - 2):
            p, q = 1 + i * around, 1 + (i + 1) * around
            F += [(p + j, q + j, p + k), (p + k, q + j, q + k)]
        q = 1 + (rings - 2) * around
        F.append((len(V) - 1, q + k, q + j))
    return V, np.array(F)
