"""The command line: kinds and numbers, a row a kind."""

import argparse
import json
import os
import signal
import sys

from . import __doc__ as about
from . import kinds
from .errors import NoModel, Unreadable
from .judge import Judge
from .mesh_file import mesh_text
from .minimise import Minimiser
from .surface import faults, read_off, write_off

RIGHT, WRONG, USAGE, INTERRUPTED = 0, 1, 2, 130
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
HAS_MESH = "It has a mesh by construction."


def numbers(text):
    try:
        first, last = (text.split("-") * 2)[:2]
        found = range(int(first), int(last) + 1)
    except ValueError as e:
        raise argparse.ArgumentTypeError("a number or two, for instance 1-10") from e
    if not found:
        raise argparse.ArgumentTypeError("the second number is smaller than the first")
    return found


def arguments(given):
    parser = argparse.ArgumentParser(prog="stress", description=about,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=os.path.join(ROOT, "build", "release", "bin", "overtet"), metavar="PATH",
                        help="the program to judge (default: build/release/bin/overtet)")
    parser.add_argument("--kinds", nargs="+", choices=kinds.ALL, default=list(kinds.ALL), metavar="K",
                        help="kinds of models (default: all)")
    parser.add_argument("--seeds", type=numbers, default=range(1, 11), metavar="A-B", help="numbers (default: 1-10)")
    parser.add_argument("--again", nargs="+", metavar="FILE", help="judge kept files or folders of them instead")
    parser.add_argument("--time", type=float, default=60, metavar="S", help="seconds for an answer (default: 60)")
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="threads of the program (default: 1)")
    parser.add_argument("--repair", action="store_true", help="also repair what is infeasible")
    parser.add_argument("--keep", metavar="DIR", help="write models that fail to this folder")
    parser.add_argument("--minimise", action="store_true", help="make them small first")
    parser.add_argument("--runs", type=int, default=200, metavar="N",
                        help="runs of the program that one model may be minimised with (default: 200)")
    parser.add_argument("--json", metavar="FILE", help="write all verdicts to this file")
    parser.add_argument("--write", metavar="DIR", help="only write the models to this folder, and run nothing")
    options = parser.parse_args(given)
    if options.minimise and not options.keep:
        parser.error("--minimise needs a folder: --keep DIR")
    if options.time <= 0 or options.threads < 1 or options.runs < 0:
        parser.error("--time, --threads and --runs are positive")
    if not options.write and not os.access(options.program, os.X_OK):
        parser.error(f"{options.program} is no program; build it, or name one with --program")
    options.program = os.path.abspath(options.program)
    return options


def kept_files(places):
    for place in places:
        if os.path.isdir(place):
            yield from sorted(os.path.join(place, x) for x in os.listdir(place) if x.endswith(".off"))
        else:
            yield place


def groups(options):
    """(name of a row, [(name of a model, function that makes it)])."""
    if not options.again:
        for kind in options.kinds:
            yield kind, [(f"{kind}_{n}", lambda kind=kind, n=n: kinds.make(kind, n)) for n in options.seeds]
        return
    yield "again", [(name_of(f), lambda f=f: kept_model(f)) for f in kept_files(options.again)]


def name_of(path):
    return os.path.splitext(os.path.basename(path))[0]


def kept_model(path):
    surface, comments = read_off(path)
    wrong = faults(surface)
    if wrong:
        raise Unreadable(f"{path}: {wrong}")
    return kinds.Model(surface, has_mesh=HAS_MESH in comments)


def write_model(model, folder, name, comments):
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, name + ".off")
    write_off(model.surface, path, comments + ([HAS_MESH] if model.has_mesh else []))
    if model.solid:
        with open(os.path.join(folder, name + ".mesh"), "w", encoding="ascii") as file:
            file.write(mesh_text(model.solid.points, model.solid.tets))
    return path


class Session:
    def __init__(self, options):
        self.options = options
        self.judge = Judge(options.program, options.time, options.threads, options.repair)
        self.rows = []

    def run(self):
        for group, models in groups(self.options):
            before = len(self.rows)
            for name, make in models:
                model = make()
                if self.options.write:
                    print(write_model(model, self.options.write, name, []))
                else:
                    self.one(group, name, model)
            if not self.options.write:
                self.print_row(group, self.rows[before:])
        return WRONG if any(r["failed"] for r in self.rows) else RIGHT

    def one(self, group, name, model):
        verdict = self.judge(model)
        row = {"kind": group, "name": name, "faces": len(model.surface.faces), "verdict": verdict.what,
               "failed": verdict.failed, "seconds": round(verdict.seconds, 2), "said": verdict.said}
        self.rows.append(row)
        if verdict.failed:
            print(f"  {name}, {row['faces']} faces: {verdict.what}: {verdict.said}", flush=True)
            if self.options.keep:
                row["kept"] = self.keep(name, model, verdict)

    def keep(self, name, model, verdict):
        interrupted = None
        if self.options.minimise:
            minimiser = Minimiser(self.judge, self.options.runs)
            try:
                minimiser.minimise(model, verdict.what)
            except KeyboardInterrupt as e:
                interrupted = e
            model = minimiser.smallest
            used = self.options.runs - minimiser.left
            print(f"  {name}: {len(model.surface.faces)} faces after {used} runs", flush=True)
        said = " ".join(verdict.said.split())[:200].encode("ascii", "replace").decode()
        path = write_model(model, self.options.keep, name, [f"{name}: {verdict.what}: {said}"])
        print(f"  {name}: kept as {path}", flush=True)
        if interrupted:
            raise interrupted
        return path

    def print_row(self, group, rows):
        counts = {}
        for r in rows:
            counts[r["verdict"]] = counts.get(r["verdict"], 0) + 1
        slowest = max((r["seconds"] for r in rows), default=0)
        wrong = sum(r["failed"] for r in rows)
        said = ", ".join(f"{what} {n}" for what, n in sorted(counts.items()))
        print(f"{group:10} {len(rows):4} models, {wrong} failed: {said or 'none'}; slowest {slowest:.1f} s", flush=True)

    def save(self):
        if self.options.json:
            with open(self.options.json, "w", encoding="utf-8") as file:
                json.dump(self.rows, file, indent=1)
                file.write("\n")


def main(given):
    options = arguments(given)
    session = Session(options)
    for number in (signal.SIGINT, signal.SIGTERM):  # so that the program ends, too, and what was found is written
        signal.signal(number, signal.default_int_handler)
    try:
        return session.run()
    except (NoModel, Unreadable, OSError) as e:
        print(f"stress: {e}", file=sys.stderr)
        return USAGE
    except KeyboardInterrupt:
        return INTERRUPTED
    finally:
        session.save()
