#!/usr/bin/python3
"""Man pages are roff without warnings, and completions complete: in bash, zsh and fish themselves.

usage: shells_test.py OVERTET

Exit code 77 where a shell or groff is missing; the others are tested all the same.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

OVERTET = ""
TOOLS = ("bash", "zsh", "fish", "groff")


def run(*words, **more):
    return subprocess.run(words, check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more).stdout


def commands():
    said = run(OVERTET, "--help")
    return re.findall(r"^  ([a-z]+) ", said[said.index("Subcommands:"):], re.MULTILINE)


class Shells(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = {}
        for shell in ("bash", "zsh", "fish"):
            cls.path[shell] = os.path.join(cls.folder.name, "_overtet" if shell == "zsh" else shell)
            with open(cls.path[shell], "w", encoding="utf-8") as file:
                file.write(run(OVERTET, "completion", shell))
        for name in ("worm.off", "other.ply"):
            open(os.path.join(cls.folder.name, name), "w", encoding="utf-8").close()

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def check(self, complete):
        """complete(line): what may stand in the place of its last word."""
        self.assertLessEqual({"mesh", "inspect", "batch", "help"}, complete("overtet "))
        self.assertEqual(complete("overtet ins"), {"inspect"})
        self.assertLessEqual({"--improve", "--on-infeasible", "--output"}, complete("overtet mesh worm.off --"))
        self.assertEqual(complete("overtet mesh worm.off --on-infeasible re"), {"reject", "repair", "refine"})
        self.assertIn("worm.off", complete("overtet mesh wo"))
        self.assertEqual(complete("overtet completion z"), {"zsh"})
        self.assertNotIn("--improve", complete("overtet verify --"))

    @unittest.skipUnless(shutil.which("bash"), "no bash")
    def test_bash(self):
        def complete(line):
            words = line.split(" ")
            script = (f"source {self.path['bash']}; COMP_WORDS=({' '.join(repr(w) for w in words)}); "
                      f"COMP_CWORD={len(words) - 1}; _overtet; printf '%s\\n' \"${{COMPREPLY[@]}}\"")
            return set(run("bash", "--norc", "-c", script, cwd=self.folder.name).split())
        self.check(complete)

    @unittest.skipUnless(shutil.which("fish"), "no fish")
    def test_fish(self):
        def complete(line):
            said = run("fish", "--no-config", "-c", f"source {self.path['fish']}; complete -C '{line}'", cwd=self.folder.name)
            return {each.split("\t")[0] for each in said.splitlines()}
        self.check(complete)

    @unittest.skipUnless(shutil.which("zsh"), "no zsh")
    def test_zsh(self):
        # A zsh in a terminal of its own lists what would complete the line, between marks.
        listing = os.path.join(self.folder.name, "listing.zsh")
        with open(listing, "w", encoding="utf-8") as file:
            file.write("""
zmodload zsh/zpty
zpty worker zsh -f -i
ask() { zpty -w worker "$1"; }
ask 'PS1=""; PS2=""; unsetopt zle_bracketed_paste 2>/dev/null; stty -echo'
ask "fpath=($2 \\$fpath); autoload -U compinit; compinit -u -D; compdef _overtet overtet"
ask 'compadd() { local -A o; local -a h; [[ ${@[1,(i)(-|--)]} == *-(O|A|D)\ * ]] && { builtin compadd "$@"; return $?; }
  local -a __hits; builtin compadd -A __hits "$@"; for h in $__hits; do print -r -- "HIT<$h>"; done; builtin compadd "$@" }'
ask 'zstyle ":completion:*" list-grouped false; finish() { print -r -- "END"; exit; }; zle -N finish; bindkey "^X" finish; bindkey "^I" list-choices'
sleep .3
zpty -w -n worker "$1"$'\\t'
sleep .7
zpty -w -n worker $'\\x18'
while zpty -r worker text; do print -r -- "$text"; done
""")

        def complete(line):
            said = subprocess.run(["zsh", "-f", listing, line, self.folder.name], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                  text=True, timeout=30, cwd=self.folder.name, check=False).stdout
            return {hit.split("=")[0].rstrip("+") for hit in re.findall(r"HIT<([^$>]+)>", said)}
        self.check(complete)

    @unittest.skipUnless(shutil.which("groff"), "no groff")
    def test_man_pages(self):
        for command in ("", *commands()):
            page = run(OVERTET, "manual", *([command] if command else []))
            shown = subprocess.run(["groff", "-man", "-ww", "-Tutf8", "-K", "utf8"], input=page, text=True, check=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.assertEqual(shown.stderr, "", command)
            self.assertIn("SYNOPSIS", re.sub(".\x08", "", shown.stdout))
            for option in re.findall(r"--[a-z][a-z-]*", run(OVERTET, *([command] if command else []), "--help")):
                self.assertIn(option, page.replace("\\-", "-"), command)

    def test_every_command_has_a_page(self):
        with open(os.path.join(os.path.dirname(os.path.realpath(__file__)), "../../src/cli/CMakeLists.txt"), encoding="utf-8") as file:
            listed = re.search(r"set\(commands ([a-z ]*)\)", file.read()).group(1).split()
        self.assertEqual(sorted(listed), sorted(commands()))


def main():
    global OVERTET
    OVERTET = os.path.abspath(sys.argv[1])
    result = unittest.TextTestRunner(verbosity=2).run(unittest.defaultTestLoader.loadTestsFromTestCase(Shells))
    if not result.wasSuccessful():
        return 1
    missing = [tool for tool in TOOLS if not shutil.which(tool)]
    if missing:
        print("SKIPPED: not tested with " + ", ".join(missing) + " (scripts/setup --examples installs them)")
        return 77
    return 0


if __name__ == "__main__":
    sys.exit(main())
