"""Shells with handles, cut open.

Over a shell that is a sphere layers can be told apart by names. Over one with handles they may change places on the
way round. It is cut until it is simply connected; names then change across a cut in some way, the same until the cut
branches. A tree of sides grows over the shell; where it does not pass there is a cut, but for those that end
somewhere.
"""

import collections

from ..sets import Sets


class Cuts:
    """left_out: parts with a hole on such a shell, about which nothing is said.

    names: for each cut, by its owner and the number of the sector there, the name of the change, and whether it is
    undone (goes from the second side of the sector to the first); shell_of_name: {name: shell}.
    """

    def __init__(self, shells, named):
        self.shells = shells
        self.find_corners()
        candidates = self.candidates(named)
        handled = {shells.shell_of(shells.sectors[i][1]) for i in candidates}
        self.left_out = {
            p for p, h in enumerate(shells.parts.holes) if h and {shells.shell(p, k) for k in (0, 1)} & handled
        }
        self.cut = self.off_the_tree(candidates)  # sector: its two corners
        self.at = collections.defaultdict(set)  # corner: cuts that meet there
        for i, two in self.cut.items():
            for c in two:
                self.at[c].add(i)
        self.drop_ends()
        self.names, self.shell_of_name = {}, {}
        self.name_changes()

    def is_left_out(self, i):
        return any(self.shells.side(u)[0] in self.left_out for u in self.shells.sectors[i][1:])

    def ends(self, u):
        """The corners at the ends of a piece of border, by node; such a corner is called by the piece before it."""
        return {u[2]: u, u[1]: (*self.before[u[:3]], u[3])}

    def find_corners(self):
        """Corners of sides, joined around nodes."""
        self.before = {y: x for x, y in self.shells.parts.after.items()}
        self.corners = Sets()
        for _, u, v in self.shells.sectors:
            at_u, at_v = self.ends(u), self.ends(v)
            for node in at_u:
                self.corners.join(at_u[node], at_v[node])

    def euler_numbers(self):
        """Per shell: 2 for a sphere, less for handles."""
        shells, euler = self.shells, collections.Counter()
        for part, holes in enumerate(shells.parts.holes):
            for k in (0, 1):
                euler[shells.shell(part, k)] += 1 - holes
        for _, u, _ in shells.sectors:
            euler[shells.shell_of(u)] -= 1
        for x in {self.corners.root((*piece, k)) for piece in shells.parts.after for k in (0, 1)}:
            euler[shells.shell_of(x)] += 1
        return euler

    def candidates(self, named):
        """Sectors on shells with handles, those first across which the tree had better grow."""
        shells, euler, found = self.shells, self.euler_numbers(), []
        for i, (owner, u, _) in enumerate(shells.sectors):
            shell = shells.shell_of(u)
            if shells.winding[shell] < 2 or euler[shell] == 2:
                continue
            kind, number = owner
            key = shells.edges[number][0] if kind == "edge" else shells.parts.pieces[number][:2]
            covered = kind == "edge" and shells.cover[key] > 0
            found.append((key not in named, covered, i))
        return [i for *_, i in sorted(found)]

    def off_the_tree(self, candidates):
        tree, cut = Sets(), {}
        for i in candidates:
            _, u, v = self.shells.sectors[i]
            x, y = self.shells.side(u), self.shells.side(v)
            if self.is_left_out(i) or tree.root(x) == tree.root(y):
                cut[i] = [self.corners.root(c) for c in self.ends(u).values()]
            else:
                tree.join(x, y)
        return cut

    def drop_ends(self):
        """Around a corner that but one cut leads to, names cannot change."""
        stack = list(self.at)
        while stack:
            c = stack.pop()
            if len(self.at[c]) != 1:
                continue
            (i,) = self.at[c]
            if self.is_left_out(i) or self.cut[i][0] == self.cut[i][1]:
                continue
            for other in self.cut.pop(i):
                self.at[other].discard(i)
                stack.append(other)

    def turns_left(self, i, c):
        """Whether from the first side of a sector to the second one goes counter-clockwise around corner c."""
        u = self.shells.sectors[i][1]
        return (self.corners.root(u) == c) != (u[3] == 1)

    def name_changes(self):
        first = {}  # sector of an owner
        for i, (owner, _, _) in enumerate(self.shells.sectors):
            first.setdefault(owner, i)
        changes = {}
        for start in self.cut:
            if start not in changes:
                self.shell_of_name["name", start] = self.shells.shell_of(self.shells.sectors[start][1])
                changes[start] = (start, False)
                self.follow(start, changes)
        for i, (name, undone) in changes.items():
            owner = self.shells.sectors[i][0]
            self.names[owner, i - first[owner]] = (("name", name), undone)

    def follow(self, start, changes):
        """Along a cut in both directions, until it branches."""
        arc = [start]
        for i in arc:
            for c in self.cut[i]:
                ends = [k for k in self.at[c] for x in self.cut[k] if x == c]
                if len(ends) != 2 or ends[0] == ends[1]:
                    continue
                other = ends[ends[0] == i]
                if other not in changes:
                    undone = changes[i][1] != (self.turns_left(i, c) == self.turns_left(other, c))
                    changes[other] = (start, undone)
                    arc.append(other)

    def is_cut(self, owner):
        return any((owner, k) in self.names for k in range(4))

    def changes(self, owner):
        """Names that change around an edge or piece of curve: (sector, name, undone)."""
        return tuple((k, *self.names[owner, k]) for k in range(4) if (owner, k) in self.names)
