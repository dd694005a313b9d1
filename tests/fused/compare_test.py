"""overtet compare --fused: its figures, and how distances differ from those in the mesh of overtet mesh."""
import json
import os
import subprocess
import sys
import tempfile

PROGRAM, SOURCE = sys.argv[1:3]


def run(*words, code=0):
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False)
    assert done.returncode == code, (words, done.returncode, done.stderr)
    return done.stdout + done.stderr


def main():
    with tempfile.TemporaryDirectory() as folder:
        worm, ours, fused = (os.path.join(folder, name) for name in ("worm.off", "ours.vtu", "fused.vtu"))
        subprocess.run([sys.executable, "-B", os.path.join(SOURCE, "scripts", "make_sample"), worm, "390", "16"],
                       check=True, stdout=subprocess.DEVNULL)
        run("mesh", worm, "-o", ours)
        figures = json.loads(run("compare", worm, "--fused", "-o", fused, "--json"))
        assert figures["components"] == 1 and figures["cut_faces"] > 0 and figures["inner_vertices"] > 0, figures
        assert 0.9 < figures["volume"] / figures["solid_volume"] < 0.99, figures
        # Vertex 0 is the tip of the tail, which the head covers: the fused mesh has no long way between them.
        farthest = [json.loads(run("solve", "geodesic", mesh, "-o", os.path.join(folder, "d.vtu"), "--from", "vertices:0", "--json"))["most"]
                    for mesh in (ours, fused)]
        assert farthest[1] < 0.7 * farthest[0], farthest
        assert "the fused mesh" in run("compare", worm, "--fused", "-o", fused)
        assert "--fused" in run("compare", worm, "-o", fused, code=2)
        assert "closed" in run("compare", "--strict", broken(worm, folder), "--fused", "-o", fused, code=3)


def broken(worm, folder):
    """Without its last face."""
    with open(worm, encoding="ascii") as f:
        lines = f.read().split("\n")
    counts = lines[1].split()
    lines[1] = f"{counts[0]} {int(counts[1]) - 1} 0"
    while not lines[-1]:
        lines.pop()
    path = os.path.join(folder, "open.off")
    with open(path, "w", encoding="ascii") as f:
        f.write("\n".join(lines[:-1]) + "\n")
    return path


main()
