"""Processes of the test: found by what their command lines and environments name, started so that none is left behind."""
import ctypes
import os
import signal
import subprocess
import time

PR_SET_PDEATHSIG = 1


class Failure(Exception):
    """Something that should be is not; the message says what."""


def die_with_parent():
    """For preexec_fn: the process is killed when the one that started it ends, however that ends."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def run(*command, fails=False, **more):
    """The output of a command; a failure when it ends with another exit code than 0 (any, with `fails`)."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
                          preexec_fn=die_with_parent, **more)
    if done.returncode != 0 and not fails:
        raise Failure(f"{' '.join(command)}\nended with {done.returncode}:\n{done.stdout[-4000:]}")
    return done.stdout


def wait_for(what, condition, seconds):
    """Waits until the condition holds and returns what it gave back."""
    end = time.monotonic() + seconds
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            raise Failure(f"waited {seconds} s for this, in vain: {what}")
        time.sleep(0.02)


def words(pid, name="cmdline"):
    try:
        with open(f"/proc/{pid}/{name}", "rb") as f:
            return f.read().decode(errors="replace").split("\0")[:-1]
    except OSError:
        return []


def parent(pid):
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as f:
            return int(f.read().rsplit(")", 1)[1].split()[1])
    except (OSError, IndexError):
        return 0


def all_pids():
    return [int(name) for name in os.listdir("/proc") if name.isdigit()]


def descendants(root):
    """A process and all below it, parents first."""
    parents = {pid: parent(pid) for pid in all_pids()}
    found = [root]
    for pid in found:
        found += [child for child, its_parent in parents.items() if its_parent == pid]
    return found


def batch_of(out, shard):
    """The process of `overtet batch` that works on a shard ("2/5") into a folder; none: 0."""
    for pid in all_pids():
        command = words(pid)
        if command[1:2] == ["batch"] or command[2:3] == ["batch"]:
            if out in command and shard in command and "batch" not in words(parent(pid))[1:3]:
                return pid
    return 0


def workers_of(batch):
    return descendants(batch)[1:]


def state(pid):
    """As in `man proc`: R running, S sleeping, T stopped, Z ended; empty: gone."""
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as f:
            return f.read().rsplit(")", 1)[1].split()[0]
    except (OSError, IndexError):
        return ""


def hold(pid):
    """Stops a process; False if it has ended before."""
    kill([pid], signal.SIGSTOP)
    for _ in range(100):
        if state(pid) in ("T", "Z", ""):
            break
        time.sleep(0.01)
    return state(pid) == "T"


def stop_worker(batch):
    """Lets a batch that was held go on, and stops its worker and what that has started: those processes."""
    kill([batch], signal.SIGCONT)

    def stopped():
        workers = workers_of(batch)
        kill(workers, signal.SIGSTOP)
        time.sleep(0.01)
        states = {pid: state(pid) for pid in workers}
        if not all(s in ("T", "Z", "") for s in states.values()):
            return []
        return [pid for pid, s in states.items() if s == "T"]  # none: it ended just then, and the next one will come
    return wait_for(f"a worker of process {batch}", stopped, 20)


def kill(pids, number=signal.SIGKILL):
    for pid in pids:
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            pass


def left_of(folder):
    """Processes that have something to do with a folder: by command line, environment or working folder."""
    found = []
    for pid in all_pids():
        if pid == os.getpid() or state(pid) in ("Z", ""):
            continue
        try:
            where = os.readlink(f"/proc/{pid}/cwd")
        except OSError:
            where = ""
        if where.startswith(folder) or any(folder in w for w in words(pid) + words(pid, "environ")):
            found.append(pid)
    return found
