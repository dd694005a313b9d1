"""What `test` in the folder above runs once everything is there."""
import argparse
import os
import shutil
import signal
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, os.path.dirname(HERE))

from testing.engines import ENGINES, Test, say  # noqa: E402
from testing.models import make_models  # noqa: E402
from testing.processes import Failure, kill, left_of, run, words  # noqa: E402
from testing.results import answers, verify_all  # noqa: E402


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default=os.path.join(HERE, "../../../build/release/bin/overtet"))
    parser.add_argument("--engines", nargs="+", choices=ENGINES, default=list(ENGINES))
    parser.add_argument("--installed", action="store_true")  # for `test`
    parser.add_argument("--keep", action="store_true")
    return parser.parse_args()


def test_all(args, program, folder):
    models, plain = os.path.join(folder, "models"), os.path.join(folder, "plain")
    count = make_models(models)
    run(program, "batch", models, "-o", plain)
    wanted = answers(plain)
    if len(wanted) != count:
        raise Failure(f"a batch of one piece has {len(wanted)} answers for {count} models")
    statuses = sorted({status for status, _, _ in wanted.values()})
    say(f"{count} models in one batch: {', '.join(f'{sum(a[0] == s for a in wanted.values())} {s}' for s in statuses)}; "
        f"{verify_all(program, plain, models)} meshes verified")
    for engine in args.engines:
        ENGINES[engine](Test(program, folder, models, wanted))


def main():
    args = arguments()
    program = os.path.realpath(args.program)
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, _: sys.exit(128 + number))
    start = time.monotonic()
    folder = tempfile.mkdtemp(prefix="overtet-cluster-")
    code = 1
    try:
        test_all(args, program, folder)
        code = 0
    except Failure as failure:
        print(f"FAILED: {failure}", flush=True)
    except (KeyboardInterrupt, SystemExit) as interrupt:
        code = 130 if isinstance(interrupt, KeyboardInterrupt) else interrupt.code
    finally:
        left = left_of(folder)
        if left and code == 0:
            code = 1
            commands = [" ".join(words(pid)) for pid in left]
            print("FAILED: still running (killed now):", *commands, sep="\n  ")
        kill(left)
        if args.keep or code == 1:
            print(f"Models, results and logs: {folder}")
        else:
            shutil.rmtree(folder, ignore_errors=True)
    if code == 0:
        say(f"passed in {time.monotonic() - start:.0f} s; no process is left")
    return code


if __name__ == "__main__":
    sys.exit(main())
