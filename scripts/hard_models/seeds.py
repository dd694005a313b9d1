"""Random numbers that are the same on every machine."""

import hashlib
import random


def source_of(kind, number, attempt=0):
    text = f"{kind} {number} {attempt}".encode()
    return random.Random(int.from_bytes(hashlib.sha256(text).digest(), "big"))


def on_grid(points, bits=20):
    """Points rounded to multiples of 2^-bits: sines differ in their last bits from machine to machine."""
    unit = float(1 << bits)
    return [tuple(round(x * unit) / unit + 0.0 for x in p) for p in points]
