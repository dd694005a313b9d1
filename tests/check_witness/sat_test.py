"""Formulas, the solver, and the check of proofs: right ones are accepted, others are not."""

import itertools
import os
import random
import stat
import tempfile
import unittest
from unittest import mock

import support  # noqa: F401
from witness_checker.errors import Undecided
from witness_checker.sat import solver
from witness_checker.sat.bijections import identity, inverse, then, unknown
from witness_checker.sat.formula import FALSE, TRUE, Formula
from witness_checker.sat.layers import one_cycle
from witness_checker.sat.rup import Wrong, check_proof

SEED = 1


def random_clauses(seed):
    rng = random.Random(seed)
    variables = rng.randint(4, 9)
    some = [rng.sample(range(1, variables + 1), min(variables, rng.choice((2, 3, 3)))) for _ in range(5 * variables)]
    return [tuple(x * rng.choice((1, -1)) for x in clause) for clause in some], variables


def is_satisfiable(clauses, variables):
    for signs in itertools.product((1, -1), repeat=variables):
        if all(any(signs[abs(x) - 1] * x > 0 for x in clause) for clause in clauses):
            return True
    return False


def formula_of(clauses, variables):
    formula = Formula()
    formula.variables, formula.clauses = variables, list(clauses)
    return formula


def pigeons(holes):
    """One more than there are holes."""
    formula = Formula()
    into = [[formula.new() for _ in range(holes)] for _ in range(holes + 1)]
    for row in into:
        formula.add(*row)
    for hole in range(holes):
        for a, b in itertools.combinations(into, 2):
            formula.add(-a[hole], -b[hole])
    return formula


def proof_of(formula):
    """What the solver writes."""
    with tempfile.TemporaryDirectory() as folder:
        question, proof = os.path.join(folder, "q"), os.path.join(folder, "p")
        with open(question, "w", encoding="ascii") as file:
            file.write(formula.text())
        code, _ = solver.run([solver.PROGRAM, "-q", "--plain", "--no-binary", question, proof])
        with open(proof, encoding="ascii") as file:
            return code, file.read()


def accepts(clauses, proof):
    try:
        check_proof(clauses, proof)
    except Wrong:
        return False
    return True


def damaged(proof, rng):
    """One line less, one literal another, one literal less, or a line too early."""
    lines = proof.splitlines()
    k = rng.randrange(len(lines))
    words = lines[k].split()
    literals = [i for i, word in enumerate(words) if word not in ("d", "0")]
    kind = rng.randrange(4)
    if kind == 0 or not literals:
        del lines[k]
    elif kind == 1:
        i = rng.choice(literals)
        words[i] = str(-int(words[i]))
        lines[k] = " ".join(words)
    elif kind == 2:
        del words[rng.choice(literals)]
        lines[k] = " ".join(words)
    else:
        lines.insert(rng.randrange(k + 1), lines.pop(k))
    return "\n".join(lines) + "\n"


class Proofs(unittest.TestCase):
    def test_random_clauses(self):
        print(f"seeds from {SEED}")
        seen = {True: 0, False: 0}
        for seed in range(SEED, SEED + 120):
            clauses, variables = random_clauses(seed)
            expected = is_satisfiable(clauses, variables)
            seen[expected] += 1
            with self.subTest(seed=seed):
                self.assertEqual(solver.can_be_satisfied(formula_of(clauses, variables)), expected)
        self.assertGreater(min(seen.values()), 10)

    def test_what_can_be_satisfied_is_never_refuted(self):
        """Proofs of clauses that contradict each other, for fewer clauses, and damaged."""
        tried = 0
        for seed in range(SEED, SEED + 120):
            rng = random.Random(seed)
            clauses, variables = random_clauses(seed)
            if is_satisfiable(clauses, variables):
                continue
            code, proof = proof_of(formula_of(clauses, variables))
            self.assertEqual(code, solver.UNSATISFIABLE)
            while not is_satisfiable(clauses, variables):
                clauses.pop(rng.randrange(len(clauses)))
            with self.subTest(seed=seed):
                self.assertFalse(accepts(clauses, proof))
                for _ in range(20):
                    proof = damaged(proof, rng) if proof.strip() else "0\n"
                    self.assertFalse(accepts(clauses, proof))
                    tried += 1
        self.assertGreater(tried, 200)

    def test_damaged_proofs(self):
        formula = pigeons(5)
        code, proof = proof_of(formula)
        self.assertEqual(code, solver.UNSATISFIABLE)
        self.assertTrue(accepts(formula.clauses, proof))
        lines = proof.splitlines()
        added = [line for line in lines if not line.startswith("d")]
        self.assertGreater(len(added), 20)
        self.assertTrue(accepts(formula.clauses, "\n".join(added)))  # nothing forgotten
        self.assertFalse(accepts(formula.clauses, ""))
        self.assertFalse(accepts(formula.clauses, "0\n"))
        self.assertFalse(accepts(formula.clauses, "\n".join(lines[: len(lines) // 2])))
        self.assertFalse(accepts(formula.clauses, "\n".join(reversed(lines))))
        self.assertFalse(accepts(formula.clauses[:-1], proof))
        self.assertFalse(accepts(formula.clauses, added[0].replace(" 0", "")))
        self.assertFalse(accepts(formula.clauses, "2 x 0\n" + proof))
        everything = "".join(f"d {' '.join(map(str, c))} 0\n" for c in formula.clauses)
        self.assertFalse(accepts(formula.clauses, everything + proof))
        fresh = formula.variables + 1
        self.assertFalse(accepts(formula.clauses, f"{fresh} 0\n" + proof))  # satisfiable as before, but no RUP step
        rng = random.Random(SEED)
        refused = sum(not accepts(formula.clauses, damaged(proof, rng)) for _ in range(200))
        self.assertGreater(refused, 20)  # many steps are not needed

    def test_contradictions_at_once(self):
        self.assertTrue(accepts([()], ""))
        self.assertTrue(accepts([(1,), (-1,)], ""))
        self.assertTrue(accepts([(1, 2), (-1,), (-2,)], ""))
        self.assertFalse(accepts([], ""))
        self.assertFalse(accepts([(1, -1)], "0\n"))


class Solver(unittest.TestCase):
    """Programs that are no solvers, or lie."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        path = mock.patch.dict(os.environ, {"PATH": self.folder})
        path.start()
        self.addCleanup(path.stop)

    def pretend(self, text):
        program = os.path.join(self.folder, solver.PROGRAM)
        with open(program, "w", encoding="ascii") as file:
            file.write("#!/bin/sh\n" + text)
        os.chmod(program, stat.S_IRWXU)

    def refuses(self, formula, words):
        with self.assertRaisesRegex(Undecided, words):
            solver.can_be_satisfied(formula)

    def test_missing(self):
        self.refuses(pigeons(2), "not installed")

    def test_lies(self):
        can = Formula()
        can.add(can.new(), can.new())
        self.pretend("echo 0 > $5; exit 20\n")
        self.refuses(can, "proof")
        self.refuses(pigeons(2), "proof")
        self.pretend("exit 20\n")
        self.refuses(pigeons(2), "proof")
        self.pretend("echo s SATISFIABLE; echo v 1 2 3 4 5 6 7 0; exit 10\n")
        self.refuses(pigeons(2), "values")
        self.assertTrue(solver.can_be_satisfied(can))
        self.pretend("echo v 1 -1 2 -2 3 -3 4 -4 5 -5 6 -6 7 -7 0; exit 10\n")
        self.refuses(pigeons(2), "values")
        self.pretend("exit 10\n")
        self.refuses(can, "values")
        self.pretend("exit 0\n")
        self.refuses(can, "without an answer")
        self.pretend("kill -9 $$\n")
        self.refuses(can, "without an answer")


class Formulas(unittest.TestCase):
    def test_constants(self):
        formula = Formula()
        x = formula.new()
        before = len(formula.clauses)
        formula.add(TRUE, x)
        formula.add(x, -x)
        formula.implies((FALSE,), x)
        self.assertEqual(len(formula.clauses), before)
        formula.add(FALSE, x)
        self.assertEqual(formula.clauses[-1], (x,))

    def test_counts(self):
        for n in range(5):
            for number in range(-1, n + 2):
                for values in itertools.product((False, True), repeat=n):
                    formula = Formula()
                    literals = [formula.new() for _ in range(n)]
                    formula.count_is(literals, number)
                    for x, value in zip(literals, values):
                        formula.add(x if value else -x)
                    # What is counted follows from the values, so that units decide.
                    self.assertEqual(not accepts(formula.clauses, ""), sum(values) == number)

    def fixed(self, formula, ways):
        square = unknown(formula, len(ways))
        for a, b in enumerate(ways):
            formula.add(square[a][b])
        return square

    def test_bijections(self):
        for first, second in itertools.product(itertools.permutations(range(3)), repeat=2):
            for known in range(4):
                formula = Formula()
                squares = [
                    [[TRUE if w[a] == b else FALSE for b in range(3)] for a in range(3)]
                    if known >> k & 1
                    else self.fixed(formula, w)
                    for k, w in enumerate((first, second))
                ]
                both = then(formula, *squares)
                for a in range(3):
                    formula.add(both[a][second[first[a]]])
                self.assertFalse(accepts(formula.clauses, ""))
                self.assertTrue(solver.can_be_satisfied(formula))
                formula.add(-both[0][second[first[0]]])
                self.assertFalse(solver.can_be_satisfied(formula))
        self.assertEqual(inverse(identity(3)), identity(3))

    def test_one_cycle(self):
        """All permutations of up to three layers and the end, with all bounds."""
        for n in range(1, 4):
            for turn in itertools.permutations(range(n + 1)):
                cycle = [n]
                while turn[cycle[-1]] != n:
                    cycle.append(turn[cycle[-1]])
                others = all(turn[a] == a for a in range(n + 1) if a not in cycle)
                for most in range(1, n + 1):
                    formula = Formula()
                    turns = one_cycle(formula, self.fixed(formula, turn), most)
                    right = others and len(cycle) - 1 <= most
                    self.assertEqual(solver.can_be_satisfied(formula), right)
                    if right:
                        formula.count_is(turns, len(cycle) - 1)
                        self.assertTrue(solver.can_be_satisfied(formula))
                        for x in turns:  # nothing else may be counted
                            one, other = (formula_of([*formula.clauses, (y,)], formula.variables) for y in (x, -x))
                            self.assertNotEqual(solver.can_be_satisfied(one), solver.can_be_satisfied(other))


if __name__ == "__main__":
    unittest.main()
