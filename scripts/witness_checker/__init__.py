"""Checks the reason that Overtet gives for "infeasible", without Overtet.

Usage: check_witness SURFACE REPORT.json

SURFACE: OFF, OBJ, PLY or STL, triangles. REPORT.json: of `overtet mesh --report` (or the bare witness).
Exit code: 0 the witness proves that no mesh exists, 1 it does not, 2 something could not be read, 3 undecided,
because a tool is missing or its answer does not hold. Python needs numpy (Debian's package `python3-numpy`).

Witnesses:

  {"rule": "area", "face": f, "vertices": [a, b, c]}
                                        the face has no area
  {"point": [x, y, z], "winding": w}    the surface winds around the point a negative number of times;
                                        positive tets can only add to that number
  {"vertex": v, "B0": b}                the integer B0 of the vertex is negative
  {"rule": "fold", "vertices": [v], "B0": [b]}
                                        the same, where two faces lie flat on each other or almost
  {"rule": "unpaired", "vertices": [...], "B0": [...]}
                                        B0 is odd at these vertices, and covered edges join them to no
                                        other such vertex, and their number is odd
  {"rule": "crowded", "vertices": [v], "B0": [b]}
                                        the edges of the vertex cannot take the turns that B0 asks for
  {"rule": "link", "vertices": [v], "B0": [b]}
                                        no tets fill the space around the vertex, whatever turns its edges make
  {"rule": "shared", "vertices": [v, ...], "layers": [l, ...], "room": c}
                                        at the place of these vertices, and of whatever else passes through it, tets need
                                        more layers than the winding number has room for
  {"rule": "stack", "face": f, "place": [x, y, z], "vertices": [...], "moves": [...], "winding": w}
                                        coplanar faces lie on each other; if each vertex moves by its multiple of the
                                        normal of the face, however scaled down, the winding number becomes w < 0
  {"rule": "gluing", "pairs": [[f, g], ...], "layers": [m, ...], "edges": [[a, b], ...]}
                                        no way to glue the layers of a solid is right around all the curves in
                                        which these faces cross and at these edges

That of `unpaired` may have a key "apart": [x, y, z]. It then concerns only the component of the vertices named (and so
does B0), moved away from the rest of the surface in this direction, however little.

Each rule is a module of rules/, which says why it is a proof.

What is exact: everything that decides. Coordinates are the very doubles of the file as integers, times a power of two;
winding numbers, B0 and levels of edges are sums of signs of their determinants, and points between are fractions. No
angle is computed. Doubles only skip faces whose boxes are far from a ray, point or segment, with a margin that is a
thousand times what rounding can do.

How it differs from the program: B0 is found in two ways that must agree, by turns (geometry/turns.py; the
program, too, counts turns, past other directions) and, where the link is in general position, by counting faces, edges
and vertices of layers (geometry/euler.py). For `link`, `shared` and `gluing` the program searches for gluings; here
their existence is a formula made from the conditions that a gluing satisfies (sat/layers.py, sat/disc.py,
sat/gluing.py). The SAT solver CaDiCaL (Debian's package `cadical`) looks for an answer, and is not believed: "no" needs a
proof, every step of which is checked (sat/rup.py); "yes" needs values that satisfy all clauses. Where the solver is
missing, or its proof does not hold, the exit code is 3. How faces are cut along their crossings
(geometry/parts.py, shells.py, cuts.py, link.py) follows the program's definitions.
"""
