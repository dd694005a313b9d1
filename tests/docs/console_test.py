#!/usr/bin/python3
"""Runs the commands of the tutorial, and compares what they print with what the page says, but for the numbers.

usage: console_test.py SOURCE_FOLDER PROGRAM

What stands in blocks marked `console`: lines with `$ ` are commands, what follows is their output. There `...` stands for
anything. Ends with 77 where numpy is missing.
"""
import importlib.util
import os
import re
import subprocess
import sys
import tempfile

PAGES = ["docs/site/tutorial.md"]


def blocks(text):
    return re.findall(r"^```console\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def commands(block):
    """(command, output) of a block."""
    found = []
    for line in block.splitlines():
        if line.startswith("$ "):
            found.append((line[2:], []))
        else:
            found[-1][1].append(line)
    return [(command, "\n".join(output)) for command, output in found]


def pattern(output):
    """What fits to the output: any numbers, and anything for `...`."""
    out = re.escape(output)
    out = re.sub(r"\\\.\\\.\\\.", ".*", out)
    return re.sub(r"(\\-)?\d+((\\\.|:)\d+)*(e(\\-)?\d+)?", r"-?[0-9.:]+(e-?[0-9]+)?", out)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    if not importlib.util.find_spec("numpy"):
        print("SKIPPED: the commands of the tutorial were NOT run: python3-numpy (Debian) not installed.")
        return 77
    root, program = map(os.path.abspath, sys.argv[1:])
    wrong = ran = last = 0
    for page in PAGES:
        with open(os.path.join(root, page), encoding="utf-8") as file:
            text = file.read()
        with tempfile.TemporaryDirectory() as folder:
            for name in ("examples", "scripts"):
                os.symlink(os.path.join(root, name), os.path.join(folder, name))
            environment = dict(os.environ, PATH=os.path.dirname(program) + ":" + os.environ["PATH"], PYTHONDONTWRITEBYTECODE="1")
            for block in blocks(text):
                for command, output in commands(block):
                    done = subprocess.run(["sh", "-c", command.replace("$?", str(last))], cwd=folder, env=environment, text=True,
                                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
                    last, ran = done.returncode, ran + 1
                    if not re.fullmatch(pattern(output), done.stdout.strip("\n"), re.DOTALL):
                        wrong += 1
                        print(f"{page}: $ {command}\nended with {last} and prints:\n{done.stdout}\nThe page has:\n{output}\n")
    if not ran:
        sys.exit("No commands were found.")
    print(f"{ran} commands print what the page says" if not wrong else f"{wrong} of {ran} commands print something else")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
