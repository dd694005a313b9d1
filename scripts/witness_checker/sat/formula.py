"""Clauses: what must be true, as sets of literals (integers, negative where negated) one of which holds."""

TRUE, FALSE = 1, -1


class Formula:
    """Variable 1 is true, so that constants can stand where literals do."""

    def __init__(self):
        self.variables = 1
        self.clauses = [(TRUE,)]

    def new(self):
        self.variables += 1
        return self.variables

    def add(self, *literals):
        """One of these holds."""
        kept = {x for x in literals if x != FALSE}
        if TRUE not in kept and not any(-x in kept for x in kept):
            self.clauses.append(tuple(sorted(kept)))

    def implies(self, conditions, *literals):
        """If all conditions hold, one of the literals does."""
        self.add(*(-x for x in conditions), *literals)

    def same(self, conditions, x, y):
        """If all conditions hold, x is y."""
        self.implies((*conditions, x), y)
        self.implies((*conditions, y), x)

    def exactly_one(self, literals):
        self.add(*literals)
        for k, x in enumerate(literals):
            for y in literals[:k]:
                self.add(-x, -y)

    def any_of(self, literals):
        """A literal that says whether one of these holds."""
        out = self.new()
        self.add(-out, *literals)
        for x in literals:
            self.add(-x, out)
        return out

    def count_is(self, literals, number):
        """Exactly so many of these hold: counted one by one, up to one more than that."""
        if not 0 <= number <= len(literals):
            self.add()
            return
        least = [TRUE] + [FALSE] * (number + 1)  # entry j: at least j of those looked at hold
        for x in literals:
            following = [TRUE]
            for j in range(1, number + 2):
                more = self.new()
                self.same((x,), more, least[j - 1])
                self.same((-x,), more, least[j])
                following.append(more)
            least = following
        self.add(least[number])
        self.add(-least[number + 1])

    def text(self):
        """In the form that solvers read (DIMACS)."""
        lines = [f"p cnf {self.variables} {len(self.clauses)}"]
        lines += [" ".join(map(str, (*clause, 0))) for clause in self.clauses]
        return "\n".join(lines) + "\n"
