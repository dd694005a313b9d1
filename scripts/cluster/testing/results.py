"""What a batch has left in a folder, and whether it is what it should be."""
import csv
import glob
import hashlib
import json
import os

from .processes import Failure, run


def lines_of(path):
    try:
        with open(path, "rb") as f:
            return f.read().splitlines(keepends=True)
    except FileNotFoundError:
        return []


def finished(out, shard=None):
    """The entries of a shard ("2/5") or of all in the journals of a folder; a line that is cut off is none."""
    name = "journal*.jsonl" if shard is None else "journal-{}-of-{}.jsonl".format(*shard.split("/"))
    lines = [line for path in sorted(glob.glob(os.path.join(glob.escape(out), name))) for line in lines_of(path)]
    return [json.loads(line) for line in lines if line.endswith(b"\n")]


def files_of(entry, out):
    """The entry's results: name, contents, inode and time, which show whether they were written again."""
    found = {}
    for output in entry["outputs"]:
        path = os.path.join(out, output["file"])
        with open(path, "rb") as f:
            state = os.fstat(f.fileno())
            found[output["file"]] = (hashlib.sha256(f.read()).hexdigest(), state.st_ino, state.st_mtime_ns)
    return found


class Snapshot:
    """What was done at some moment must be what it was at the end: nothing done twice, nothing lost."""

    def __init__(self, out):
        self.out = out
        self.entries = {e["name"]: e for e in finished(out)}
        self.files = {e["name"]: files_of(e, out) for e in self.entries.values()}

    def check(self):
        now = {e["name"]: e for e in finished(self.out)}
        for name, entry in self.entries.items():
            if now.get(name) != entry or files_of(entry, self.out) != self.files[name]:
                raise Failure(f"{name} was finished before the interruption and has been done again or lost")
        return len(self.entries)


def answers(out):
    """Status and contents of the results by name."""
    return {e["name"]: (e["status"], e["exit_code"], {file: state[0] for file, state in files_of(e, out).items()})
            for e in finished(out)}


def check_results(out, wanted):
    """Every model once, in journals and summary, with the wanted answers, and nothing besides. A text of what was seen."""
    names = [e["name"] for e in finished(out)]
    if sorted(names) != sorted(wanted):
        raise Failure(f"journals of {out}: {sorted(names)} instead of {sorted(wanted)}")
    found = answers(out)
    for name, answer in wanted.items():
        if found[name] != answer:
            raise Failure(f"{name}: {found[name]} instead of {answer} as in a batch of one piece")
    with open(os.path.join(out, "summary.csv"), newline="", encoding="utf-8") as f:
        rows = list(csv.DictReader(f))
    if sorted((r["name"], r["status"]) for r in rows) != sorted((n, a[0]) for n, a in wanted.items()):
        raise Failure(f"{out}/summary.csv has other models or statuses than the journals")
    for ending in ("json", "html"):
        if os.path.getsize(os.path.join(out, "summary." + ending)) == 0:
            raise Failure(f"{out}/summary.{ending} is empty")
    allowed = {file for _, _, files in wanted.values() for file in files} | {name + ".json" for name in wanted}
    allowed |= {"summary.csv", "summary.json", "summary.html"}
    more = [f for f in os.listdir(out) if f not in allowed and not f.startswith("journal")
            and not os.path.isdir(os.path.join(out, f))]
    if more:
        raise Failure(f"{out} has files that nobody asked for: {more}")
    return f"each of {len(wanted)} models once in journals and summary, statuses and meshes as in a batch of one piece"


def verify_all(program, out, models):
    """Lets the program verify every mesh; how many there were."""
    count = 0
    for entry in finished(out):
        for output in entry["outputs"]:
            run(program, "verify", entry["input"], os.path.join(out, output["file"]))
            count += 1
    return count
