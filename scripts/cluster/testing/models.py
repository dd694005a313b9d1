"""Models for the test: small, of every sort that a batch meets, some of them slow enough to be interrupted."""
import os
import sys

from .processes import run

SCRIPTS = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..")
KINDS = ("bend", "poke", "wave", "fan")  # of scripts/stress; many of `poke` and `wave` have no mesh
WORMS = range(20, 48, 2)  # vertices around; about half a second each


def make_models(folder):
    """Surfaces, and files that are none. Returns how many."""
    os.makedirs(folder)
    for around in WORMS:
        run(sys.executable, "-B", os.path.join(SCRIPTS, "make_sample"), f"{folder}/worm_{around}.off", "420", str(around))
    run(sys.executable, "-B", os.path.join(SCRIPTS, "stress"), "--kinds", *KINDS, "--seeds", "1-5", "--write", folder)
    for name in os.listdir(folder):
        if name.endswith(".mesh"):  # of those that are surfaces of tets
            os.remove(os.path.join(folder, name))
    with open(f"{folder}/worm_20.off", encoding="ascii") as f:
        worm = f.read().splitlines()
    vertices, faces, _ = worm[1].split()
    bad = {
        "open": [worm[0], f"{vertices} {int(faces) - 1} 0"] + worm[2:-1],
        "cut_off": worm[:100],
        "no surface": ["This is no surface."],
        "empty": [],
        "two %d words": worm,  # a good one whose name is hard on scripts
        "quote's $HOME": worm,
    }
    for name, lines in bad.items():
        with open(f"{folder}/{name}.off", "w", encoding="ascii") as f:
            f.write("".join(line + "\n" for line in lines))
    return len(os.listdir(folder))
