#!/usr/bin/python3
"""What scripts/docs is made of: wrong links are seen, and no declaration and no option is lost on the way to its page.

usage: builder_test.py SOURCE_FOLDER PROGRAM
"""
import glob
import os
import re
import subprocess
import sys
import tempfile
import unittest

PROGRAM, ROOT = os.path.abspath(sys.argv.pop()), os.path.abspath(sys.argv.pop())
sys.path.insert(0, os.path.join(ROOT, "scripts"))
from docs_builder import command_line, cpp, links, python_module, sources  # noqa: E402


class Folder(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = self.temporary.name

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)


class Pages(Folder):
    def wrong(self, html):
        self.write("a.html", html)
        self.write("b.html", '<h1 id="there">x</h1><a name="old"></a>')
        return links.check(self.folder)[1]

    def test_right_ones(self):
        self.assertEqual(self.wrong('<p id="here"><a href="#here"></a><a href="b.html#there"></a><a href="b.html#old"></a>'
                                    '<a href="b.html?q=1"></a><a href="https://www.example.org/x?y#z"></a>'
                                    '<img src="data:image/png;base64,xx">'), [])

    def test_wrong_ones(self):
        for html in ('<a href="c.html">', '<a href="#nowhere">', '<a href="b.html#nowhere">', '<a href="https://">',
                     '<a href="mailto:x">', '<a href="http://x y.org">', '<img src="c.png">', '<img src="https://example.org/c.png">',
                     '<script src="//example.org/c.js"></script>', '<link rel="stylesheet" href="https://example.org/c.css">'):
            with self.subTest(html):
                self.assertEqual(len(self.wrong(html)), 1, self.wrong(html))

    def test_modules(self):
        self.write("m.js", 'import a from "./n.js";\n')
        self.assertEqual(len(self.wrong("")), 1)

    def test_style_sheets(self):
        self.write("s.css", '@import "https://example.org/f.css"; a { background: url(x.png) }')
        self.assertEqual(len(self.wrong("")), 1)


class Sources(Folder):
    def wrong(self, text):
        for name in [*sources.pages(self.folder), "perf/README.md"]:
            self.write(name, "")
        self.write("docs/site/index.md", "\n".join(["readme", "changes", "contributing", "examples", "examples-python", "Words <a>", "b"]))
        self.write("docs/b.md", "# B")
        self.write("src/room/file.cpp", "")
        self.write("docs/a.md", text)
        return sources.check(self.folder)

    def test_links(self):
        self.assertEqual(self.wrong("[x](b.md) [x](../README.md#y) [x](#z) [x](https://example.org) `[x](c.md)`\n\n    [x](d.md)\n"), [])
        for text in ("[x](c.md)", "[x](../c.md#y)", "![x](c.png)", "[x](https://)", "[x](http:example)"):
            with self.subTest(text):
                self.assertEqual(len(self.wrong(text)), 1)

    def test_pages_in_no_list(self):
        self.assertEqual(self.wrong(""), [])
        self.write("docs/new.md", "")
        self.assertEqual(len(sources.check(self.folder)), 1)

    def test_named_paths(self):
        self.assertEqual(self.wrong("docs/b.md, `src/room/file.cpp`, src/room, src/io/read_NAME.cpp, build/docs/x"), [])
        for text in ("docs/c.md", "`src/room/other.cpp`", "see src/gone."):
            with self.subTest(text):
                self.assertEqual(len(self.wrong(text)), 1)

    def test_what_pages_say(self):
        names = {"docs/a.md": "a.md", "docs/b.md": "b.md", "docs/p.svg": "p.svg"}
        said = sources.page_text(ROOT, "docs/a.md", "[x](b.md#y) [z](../src/run) ![p](p.svg) docs/b.md `docs/b.md`", names)
        self.assertEqual(said, "[x](b.md#y) z ![p](p.svg) [docs/b.md](b.md) `docs/b.md`")


class Pictures(unittest.TestCase):
    def test_they_are_small_and_shown(self):
        shown = ""
        for path in sources.pages(ROOT):
            with open(os.path.join(ROOT, path), encoding="utf-8") as file:
                shown += file.read()
        for path in sources.files(ROOT):
            if path.startswith("docs/pictures/"):
                with self.subTest(path):
                    self.assertLess(os.path.getsize(os.path.join(ROOT, path)), 150_000)
                    self.assertIn("pictures/" + os.path.basename(path), shown)


class References(unittest.TestCase):
    def test_no_declaration_is_lost(self):
        pages = cpp.pages(ROOT)
        for path in glob.glob(os.path.join(ROOT, "include", "overtet", "*.h")):
            name = os.path.basename(path)[:-2]
            if name == "overtet":
                continue
            with open(path, encoding="utf-8") as file:
                text = file.read()
            inside = text[text.index("namespace overtet {"):text.rindex("}  // namespace overtet")].split("\n")[1:]
            shown = set(pages[f"cpp-{name}.md"].split("\n"))
            for line in inside:
                with self.subTest(f"{name}: {line}"):
                    if line.strip() and not line.startswith("//") and not re.match(r"(class|struct) \w+;", line):
                        self.assertIn(line, shown)

    def test_all_of_the_module(self):
        page = python_module.pages(ROOT)["python-module.md"]
        _, module = python_module.source(ROOT, "__init__.py")
        for name in re.findall(r'"(\w+)"', re.search(r"__all__ = (\[.*?\])", python_module.source(ROOT, "__init__.py")[0], re.DOTALL).group(1)):
            self.assertRegex(page, rf"\{{py:(function|class)\}} {name}\b")

    def test_all_commands_and_options(self):
        def help_of(*command):
            return subprocess.run([PROGRAM, *command, "--help"], check=True, stdout=subprocess.PIPE, text=True).stdout
        pages = command_line.pages(PROGRAM)
        commands = re.findall(r"^  ([a-z]+)  +\w", help_of().split("Subcommands:")[1], re.MULTILINE)
        self.assertGreaterEqual(len(commands), 10)
        self.assertEqual(sorted(pages), sorted(["command-line.md", *(f"command-{name}.md" for name in commands)]))
        for name in commands:
            for options in re.findall(r"^  (-[\w,-]+)", help_of(name), re.MULTILINE):
                with self.subTest(f"{name} {options}"):
                    self.assertIn("```{option} " + options.replace(",", ", "), pages[f"command-{name}.md"])

    def test_man_pages(self):
        roff = (".TH x 1\n.SH NAME\nx\n.SH OPTIONS\n.TP\n\\fB\\-\\-one\\fR \\fIN\\fR\nSays \\-\\-two\nand more\n.TP\n\\fB\\-h\\fR\nHelp\n"
                ".SH NOTES\nLast")
        parts = command_line.sections(roff)
        self.assertEqual(command_line.entries(parts["OPTIONS"]), [("--one N", "Says --two and more"), ("-h", "Help")])
        self.assertEqual(parts["NOTES"], ["Last"])


if __name__ == "__main__":
    unittest.main()
