"""Asks CaDiCaL (Debian's package `cadical`) whether a formula can be satisfied, and believes nothing.

"Yes" comes with values, which are put into the clauses; "no" comes with a proof, which `rup.py` checks. Where there is
no solver, or its answer does not hold, `Undecided` is raised: then nothing is confirmed, and nothing refuted.
"""

import os
import subprocess
import tempfile

from ..errors import Undecided
from .rup import Wrong, check_proof

PROGRAM = "cadical"
SATISFIABLE, UNSATISFIABLE = 10, 20  # exit codes


def can_be_satisfied(formula):
    with tempfile.TemporaryDirectory(prefix="check_witness.") as folder:
        question, proof = os.path.join(folder, "question.cnf"), os.path.join(folder, "proof")
        with open(question, "w", encoding="ascii") as file:
            file.write(formula.text())
        # Without preprocessing, whose steps may be more than unit propagation sees.
        code, said = run([PROGRAM, "-q", "--plain", "--no-binary", question, proof])
        if code == SATISFIABLE:
            check_values(formula.clauses, said)
            return True
        if code != UNSATISFIABLE:
            raise Undecided(f"{PROGRAM} ended with exit code {code} and without an answer")
        try:
            with open(proof, encoding="ascii") as file:
                check_proof(formula.clauses, file.read())
        except (OSError, UnicodeError, Wrong) as e:
            raise Undecided(f"the proof of {PROGRAM} is not right: {e}") from e
        return False


def run(command):
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError as e:
        raise Undecided(
            f"the SAT solver {PROGRAM} is not installed (apt-get install cadical), and this rule needs it"
        ) from e
    except OSError as e:
        raise Undecided(f"{PROGRAM} cannot be run: {e}") from e
    return done.returncode, done.stdout


def check_values(clauses, said):
    """Whether the values that a solver printed satisfy all clauses."""
    lines = (line.split()[1:] for line in said.splitlines() if line.startswith("v "))
    true = {int(x) for words in lines for x in words}
    if any(-x in true for x in true if x != 0) or not all(any(x in true for x in clause) for clause in clauses):
        raise Undecided(f"the values that {PROGRAM} gives do not satisfy the clauses")
