"""Runs the program on a model and judges what it does."""

import copy
import json
import os
import signal
import subprocess
import tempfile
import time

from .errors import Unreadable
from .mesh_check import mesh_faults
from .mesh_file import read_mesh
from .surface import Surface, write_off

CHECK_WITNESS = os.path.join(os.path.dirname(os.path.dirname(os.path.realpath(__file__))), "check_witness")

# What is an answer ...
MESH, INFEASIBLE, UNSOLVED, REPAIRED = "mesh", "infeasible", "unsolved", "repaired"
# ... and what is not. UNSOLVED is a failure, too, if the model has a mesh by construction.
CRASH, NO_ANSWER, BAD_EXIT, BAD_INPUT = "crash", "no answer", "wrong exit code", "called bad input"
WRONG_MESH, REFUSED_MESH, WRONG_REPAIR = "wrong mesh", "mesh not verified", "wrong repair"
FALSE_WITNESS, REFUTED = "false witness", "witness not confirmed"

MOST_TETS = 30000  # that are checked here, too, in some seconds
BUSY = 10  # times the limit: no program gets more, however little of the processor it has had
GRACE = 10  # seconds, before a program that should end is killed


class Verdict:
    def __init__(self, what, said="", failed=False, seconds=0.0):
        self.what, self.said, self.failed, self.seconds = what, said, failed, seconds


class Ran:
    def __init__(self, code, said, seconds):
        self.code, self.said, self.seconds = code, said, seconds


def run(command, limit):
    """Exit code (None if it took longer than the limit), the last line that it printed, seconds. On a busy machine it
    gets more time, until it has used as much of the processor's or ten times the limit is over."""
    start = time.monotonic()
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True) as child:
        text = None
        try:
            while text is None:
                try:
                    text = child.communicate(timeout=limit)[0]
                except subprocess.TimeoutExpired:
                    if processor_seconds(child.pid) >= limit or time.monotonic() - start >= BUSY * limit:
                        break
            if text is None:
                text, code = stopped(child), None
            else:
                code = child.returncode
        except BaseException:
            stopped(child)
            raise
    lines = text.decode(errors="replace").strip().splitlines()
    return Ran(code, lines[-1] if lines else "", time.monotonic() - start)


def processor_seconds(session):
    """What the processes of a session have used so far."""
    ticks = 0
    for name in os.listdir("/proc"):
        if name.isdigit():
            try:
                with open(f"/proc/{name}/stat", encoding="utf-8", errors="replace") as file:
                    words = file.read().rsplit(")", 1)[1].split()  # from the third on
            except OSError:
                continue  # it has ended
            if int(words[3]) == session:
                ticks += sum(map(int, words[11:15]))  # its own and those of its children that have ended
    return ticks / os.sysconf("SC_CLK_TCK")


def stopped(child):
    """Asks the program to end, with its helper; then ends it."""
    child.send_signal(signal.SIGTERM)
    try:
        return child.communicate(timeout=GRACE)[0]
    except subprocess.TimeoutExpired:
        os.killpg(child.pid, signal.SIGKILL)
        return child.communicate()[0]


def as_cleaned(model, files):
    """The model with those components turned that faced inwards, as the program says it has: that is what it then
    answers about. (Nothing else can be cleaned up about closed, oriented, manifold surfaces.)"""
    try:
        with open(files.report, encoding="utf-8") as file:
            turned = json.load(file)["input"]["clean_up"]["turned"]
    except (OSError, ValueError, KeyError, TypeError):
        return model
    faces = list(model.surface.faces)
    for first, count in turned:
        for i in range(first, first + count):
            a, b, c = faces[i]
            faces[i] = (a, c, b)
    cleaned = copy.copy(model)
    cleaned.surface = Surface(model.surface.points, faces)
    write_off(cleaned.surface, files.surface)
    return cleaned


class Judge:
    """`program`: a path. `limit`: seconds for an answer. `repair`: also try to repair what is infeasible."""

    def __init__(self, program, limit=60.0, threads=1, repair=False):
        self.program, self.limit, self.threads, self.repair = program, limit, str(threads), repair
        self.runs = 0

    def __call__(self, model):
        with tempfile.TemporaryDirectory() as folder:
            files = Files(folder)
            write_off(model.surface, files.surface)
            ran = self.mesh(files)
            verdict = self.judged(as_cleaned(model, files), files, ran)
            verdict.seconds = ran.seconds
            return verdict

    def mesh(self, files, *options):
        self.runs += 1
        return run([self.program, "mesh", files.surface, "-o", files.mesh, "--report", files.report, "--threads",
                    self.threads, *options], self.limit)

    def judged(self, model, files, ran):
        if ran.code == 0:
            return self.judged_mesh(model, files, ran)
        if ran.code == 5:
            return self.judged_witness(model, files, ran)
        if ran.code == 4:
            return Verdict(UNSOLVED, ran.said, model.has_mesh)
        if ran.code == 3 and model.surface.has_flat_face():
            return Verdict("a face without area", ran.said, model.has_mesh)
        return self.no_answer(ran)

    def no_answer(self, ran):
        if ran.code is None:
            return Verdict(NO_ANSWER, f"no answer in {self.limit:g} s", True)
        if ran.code < 0 or ran.code in (70, 126, 127) or ran.code > 128:
            return Verdict(CRASH, f"exit code {ran.code}: {ran.said}", True)
        if ran.code == 3:
            return Verdict(BAD_INPUT, ran.said, True)
        return Verdict(BAD_EXIT, f"exit code {ran.code}: {ran.said}", True)

    def judged_mesh(self, model, files, ran):
        verified = run([self.program, "verify", files.surface, files.mesh, "--threads", self.threads], 10 * self.limit)
        if verified.code != 0:
            return Verdict(REFUSED_MESH, f"verify: exit code {verified.code}: {verified.said}", True)
        try:
            points, tets = read_mesh(files.mesh)
        except Unreadable as e:
            return Verdict(WRONG_MESH, str(e), True)
        wrong = mesh_faults(model.surface, points, tets) if len(tets) <= MOST_TETS else ""
        return Verdict(WRONG_MESH, wrong, True) if wrong else Verdict(MESH, ran.said)

    def judged_witness(self, model, files, ran):
        checked = run([CHECK_WITNESS, files.surface, files.report], 10 * self.limit)
        if model.has_mesh:
            return Verdict(FALSE_WITNESS, f"{ran.said} ({checked.said})", True)
        if checked.code is None:  # slow is not wrong
            return Verdict(INFEASIBLE, f"{ran.said} (check_witness: no answer in {10 * self.limit:g} s)")
        if checked.code != 0:
            return Verdict(REFUTED, f"{ran.said} (check_witness: exit code {checked.code}: {checked.said})", True)
        return self.judged_repair(model, files, ran) if self.repair else Verdict(INFEASIBLE, ran.said)

    def judged_repair(self, model, files, ran):
        """What cannot be repaired remains infeasible."""
        again = self.mesh(files, "--on-infeasible", "repair")
        if again.code in (4, 5):
            return Verdict(INFEASIBLE, again.said)
        if again.code != 0:
            verdict = self.no_answer(again)
            verdict.said = "repairing: " + verdict.said
            return verdict
        try:
            with open(files.report, encoding="utf-8") as file:
                moved = json.load(file)["moved"]
            # More than it was by a unit in the last place, because the report rounds.
            most = min(100.0, 100 * moved["max_relative"] * (1 + 1e-9))
            points, tets = read_mesh(files.mesh)
        except (OSError, ValueError, KeyError, TypeError, Unreadable) as e:
            return Verdict(WRONG_REPAIR, f"the report or the mesh cannot be read: {e}", True)
        verified = run([self.program, "verify", files.surface, files.mesh, "--max-move", repr(most), "--threads",
                        self.threads], 10 * self.limit)
        if verified.code != 0:
            return Verdict(WRONG_REPAIR, f"verify: exit code {verified.code}: {verified.said}", True)
        wrong = mesh_faults(model.surface, points, tets, set(moved["ids"])) if len(tets) <= MOST_TETS else ""
        return Verdict(WRONG_REPAIR, wrong, True) if wrong else Verdict(REPAIRED, again.said)


class Files:
    def __init__(self, folder):
        self.surface, self.mesh, self.report = (os.path.join(folder, x) for x in ("s.off", "s.mesh", "s.json"))
