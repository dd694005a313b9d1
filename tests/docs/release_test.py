#!/usr/bin/python3
"""Everything that names the version names the same one: include/overtet/version.h decides.

usage: release_test.py SOURCE_FOLDER CMAKE_VERSION PROGRAM
"""
import os
import re
import subprocess
import sys
import unittest

ROOT, CMAKE, PROGRAM = sys.argv[1:4]
del sys.argv[1:]


def text(*path):
    with open(os.path.join(ROOT, *path), encoding="utf-8") as file:
        return file.read()


class Release(unittest.TestCase):
    version = ".".join(re.findall(r"^#define OVERTET_VERSION_\w+ (\d+)", text("include", "overtet", "version.h"), re.MULTILINE))
    heading = re.search(r"^## (\S+) \((\S+)\)$", text("CHANGELOG.md"), re.MULTILINE)

    def test_it_is_a_version(self):
        self.assertRegex(self.version, r"^\d+\.\d+\.\d+$")

    def test_cmake(self):
        self.assertEqual(CMAKE, self.version)

    def test_program(self):
        said = subprocess.run([PROGRAM, "--version"], check=True, stdout=subprocess.PIPE, text=True).stdout
        self.assertIn(self.version, said.split())
        page = subprocess.run([PROGRAM, "manual"], check=True, stdout=subprocess.PIPE, text=True).stdout
        self.assertIn(f'"Overtet {self.version}"', page.split("\n")[0])

    def test_python_package(self):
        """pyproject.toml leaves the version to setup.py, which reads the header."""
        self.assertRegex(text("pyproject.toml"), r'(?m)^dynamic = \["version"\]$')
        self.assertNotRegex(text("pyproject.toml"), r"(?m)^version")
        code = re.search(r"^def version\(\):\n(?:    .*\n)+", text("setup.py"), re.MULTILINE).group(0)
        names = {"os": os, "re": re, "ROOT": ROOT}
        exec(code, names)  # pylint: disable=exec-used
        self.assertEqual(names["version"](), self.version)

    def test_changelog(self):
        self.assertTrue(self.heading, "CHANGELOG.md has no heading with a version")
        self.assertEqual(self.heading.group(1), self.version)
        self.assertRegex(self.heading.group(2), r"^(unreleased|\d{4}-\d\d-\d\d)$")

    def test_citation(self):
        citation = text("CITATION.cff")
        self.assertRegex(citation, rf"(?m)^version: {re.escape(self.version)}$")
        released = re.search(r"^date-released: (\S+)$", citation, re.MULTILINE)
        if self.heading.group(2) == "unreleased":
            self.assertFalse(released, "what is not released has no date")
        else:
            self.assertEqual(released.group(1), self.heading.group(2))

    def test_comments(self):
        for path in (("include", "overtet", "version.h"), ("python", "overtet", "_api.py")):
            self.assertEqual(re.findall(r'for instance "(\d+\.\d+\.\d+)"', text(*path)), [self.version], path)


if __name__ == "__main__":
    unittest.main()
