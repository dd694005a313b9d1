"""Checks a proof that clauses contradict each other, step by step.

A step adds a clause that follows by unit propagation: if all its literals are false, and what must be true then is made
true again and again, some clause has no literal left (reverse unit propagation, RUP: Goldberg and Novikov 2003;
Wetzler, Heule and Hunt 2014 for the form of the file). The proof is right when a clause without literals
follows. A step may also say that a clause is not needed any more; that is done or not, since fewer clauses prove
less. Steps of other kinds (RAT) are not accepted.

Each clause watches two of its literals: as long as neither is false, it forces nothing.
"""


class Wrong(Exception):
    """The proof has a step that does not follow, or no end."""


class Checker:
    def __init__(self):
        self.clauses = []  # lists; the first two literals are watched; None where not needed any more
        self.watching = {}  # literal: clauses to look at when it becomes false
        self.true = set()
        self.order = []  # literals made true, in their order; those of the clauses themselves come first
        self.number = {}  # clause, as sorted literals: its numbers
        self.contradiction = False

    def assume(self, literals):
        """A clause that holds."""
        literals = sorted(set(literals))
        if self.contradiction or any(-x in literals for x in literals):
            return
        # Watch what is not false, if there is any.
        clause = sorted(literals, key=lambda x: -x in self.true)
        self.number.setdefault(tuple(literals), []).append(len(self.clauses))
        self.clauses.append(clause)
        if len(clause) > 1:
            for x in clause[:2]:
                self.watching.setdefault(x, []).append(len(self.clauses) - 1)
        if not clause or -clause[0] in self.true:
            self.contradiction = True
        elif len(clause) == 1 or -clause[1] in self.true:
            self.contradiction = not self.propagate([clause[0]])

    def propagate(self, literals):
        """Makes these true, and all that follows; false if that is a contradiction."""
        true, order, watching, clauses = self.true, self.order, self.watching, self.clauses
        at = len(order)
        for x in literals:
            if -x in true:
                return False
            if x not in true:
                true.add(x)
                order.append(x)
        while at < len(order):
            gone = -order[at]
            at += 1
            kept, waiting = [], watching.get(gone, [])
            for k, number in enumerate(waiting):
                clause = clauses[number]
                if clause is None:
                    continue
                if clause[0] == gone:
                    clause[0], clause[1] = clause[1], gone
                first = clause[0]
                if first in true:
                    kept.append(number)
                    continue
                for i in range(2, len(clause)):
                    if -clause[i] not in true:
                        clause[1], clause[i] = clause[i], gone
                        watching.setdefault(clause[1], []).append(number)
                        break
                else:
                    kept.append(number)
                    if -first in true:
                        watching[gone] = kept + waiting[k + 1 :]
                        return False
                    true.add(first)
                    order.append(first)
            watching[gone] = kept
        return True

    def follows(self, literals):
        """Whether a clause follows by unit propagation."""
        if self.contradiction:
            return True
        before = len(self.order)
        out = not self.propagate([-x for x in literals])
        for x in self.order[before:]:
            self.true.discard(x)
        del self.order[before:]
        return out

    def forget(self, literals):
        """A clause that is not needed any more. Those that force something are kept."""
        numbers = self.number.get(tuple(sorted(set(literals))))
        if numbers and not any(x in self.true for x in literals):
            self.clauses[numbers.pop()] = None


def read_proof(text):
    """Steps of a proof as text: (whether a clause is added, its literals)."""
    for line in text.splitlines():
        words = line.split()
        if not words or words[0] == "c":
            continue
        added = words[0] != "d"
        numbers = [int(x) for x in (words if added else words[1:])]
        if not numbers or numbers[-1] != 0 or 0 in numbers[:-1]:
            raise ValueError(f"not a step of a proof: {line}")
        yield added, numbers[:-1]


def check_proof(clauses, text):
    """Raises `Wrong` unless the text proves that the clauses contradict each other."""
    checker = Checker()
    for clause in clauses:
        checker.assume(clause)
    try:
        for added, literals in read_proof(text):
            if checker.contradiction:
                return
            if not added:
                checker.forget(literals)
            elif checker.follows(literals):
                checker.assume(literals)
            else:
                raise Wrong(f"the clause {literals} does not follow")
    except ValueError as e:
        raise Wrong(str(e)) from e
    if not checker.contradiction:
        raise Wrong("it ends without a contradiction")
