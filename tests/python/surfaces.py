"""Surfaces to test with."""
import functools
import importlib.machinery
import importlib.util
import os

import numpy as np

_SAMPLE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "make_sample")


@functools.cache
def _make_sample():
    loader = importlib.machinery.SourceFileLoader("make_sample", _SAMPLE)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("make_sample", loader))
    loader.exec_module(module)
    return module


@functools.cache
def _worm(degrees, around):
    return _make_sample().worm(degrees, around)


def worm(degrees=420, around=10):
    """A worm that bites its tail: V, F."""
    points, faces = _worm(degrees, around)[:2]
    return np.array(points), np.array(faces, np.int32)


def worm_groups(degrees=420, around=10):
    """Of each face the group that it belongs to, a number."""
    return np.unique(_worm(degrees, around)[2], return_inverse=True)[1].astype(np.int32)


def cube(size=1.0):
    V = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * size
    F = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                  [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]], np.int32)
    return V, F


def dented_ball(depth=-1.05, around=12, rings=6):
    """A ball whose north pole is pushed through the south pole: outside the winding number is negative there."""
    V = [(0, 0, depth)]
    for i in range(1, rings):
        a = np.pi * i / rings
        V += [(np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a))
              for b in 2 * np.pi * (np.arange(around) + .5 * (i % 2)) / around]
    V.append((0, 0, -1))
    F = [(0, 1 + j, 1 + (j + 1) % around) for j in range(around)]
    for i in range(rings - 2):
        a, b = 1 + i * around, 1 + (i + 1) * around
        for j in range(around):
            k = (j + 1) % around
            if i % 2 == 0:  # the upper ring is turned by half a step
                F += [(a + j, b + k, a + k), (a + j, b + j, b + k)]
            else:
                F += [(a + j, b + j, a + k), (a + k, b + j, b + k)]
    last, a = len(V) - 1, 1 + (rings - 2) * around
    F += [(last, a + (j + 1) % around, a + j) for j in range(around)]
    return np.array(V, float), np.array(F, np.int32)
