#!/usr/bin/python3
"""docs/site/faq.md has every kind of error, reason, status, verdict, defect, rule, witness, advice and warning of the sources.

usage: faq_test.py SOURCE_FOLDER
"""
import glob
import os
import re
import sys
import unittest

ROOT = sys.argv.pop() if len(sys.argv) > 1 else os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")


def text(*path):
    with open(os.path.join(ROOT, *path), encoding="utf-8") as file:
        return file.read()


def without_comments(code):
    return re.sub(r"//[^\n]*", "", code)


def enum(header, name):
    """The values of a public enum class: name -> number, or None."""
    body = re.search(rf"enum class {name}[^{{]*{{(.*?)}};", without_comments(text("include", "overtet", header)), re.DOTALL).group(1)
    return {n: int(v) if v else None for n, v in re.findall(r"(\w+)\s*(?:=\s*(\d+))?\s*(?:,|$)", body.strip())}


def words_of(path, function):
    """The string literals that a function of a source file returns or lists."""
    body = re.search(rf"^[^\n]*\b{function}\b[^\n;]*{{\n(.*?)^}}", text(*path.split("/")), re.DOTALL | re.MULTILINE).group(1)
    return body


def literals(statement):
    """String literals; those with only blanks between them are one."""
    joined = re.sub(r'"\s*"', "", statement)
    return [m.replace('\\"', '"') for m in re.findall(r'"((?:[^"\\]|\\.)*)"', joined)]


def plain(words):
    return re.sub(r"[^a-z0-9]+", " ", words.lower()).strip()


class Faq(unittest.TestCase):
    faq = text("docs", "site", "faq.md")

    def section(self, heading):
        """What stands below a heading, up to the next one."""
        begin = self.faq.index(f"\n## {heading}")
        end = self.faq.find("\n## ", begin + 1)
        return self.faq[begin:end if end > 0 else None]

    def row(self, word, heading):
        """There is a row of a table there that begins with this word as code."""
        self.assertRegex(self.section(heading), rf"(?m)^\| `{re.escape(word)}` \|", f"no row for {word} below {heading}")

    def test_error_codes(self):
        codes = enum("result.h", "ErrorCode")
        self.assertGreaterEqual(len(codes), 8)
        for name, number in codes.items():
            with self.subTest(name):  # that its link leads there is for scripts/docs to check
                self.assertRegex(self.faq, rf"(?m)^\| {number}\b[^|]*\| \[`{name}`\]\(#{number}-[a-z0-9-]+\) \|")
                self.assertRegex(self.faq, rf"(?m)^## {number}\b")

    def test_python_exceptions(self):
        classes = re.findall(r"^class (\w+)\((?:Error|Limit)\b", text("python", "overtet", "_errors.py"), re.MULTILINE)
        self.assertGreaterEqual(len(classes), 8)
        for name in classes:
            self.assertIn(f"`{name}`", self.faq)

    def test_reasons(self):
        for name in enum("result.h", "ErrorReason"):
            if name != "none":
                self.row(name, "4: unsolved")

    def test_statuses(self):
        named = re.findall(r'return "([a-z-]+)";', words_of("src/report/report.cpp", "name_of\\(RunStatus"))
        self.assertEqual(len(set(named)), len(enum("report.h", "RunStatus")))
        for name in named:
            self.row(name, "The status in a report")

    def test_verdicts(self):
        named = re.findall(r'return "([a-z-]+)";', words_of("src/certificates/diagnose.cpp", "verdict_name\\(Verdict"))
        self.assertGreaterEqual(len(set(named)), len(enum("diagnosis.h", "Verdict")))
        for name in set(named):
            self.row(name, "Verdicts")

    def test_defects(self):
        kinds = enum("cleanup.h", "DefectKind")
        for name in kinds:
            self.row(name.replace("_", "-"), "3: bad input")
        named = re.findall(r'\{"([a-z-]+)",', words_of("src/cleanup/cleanup.cpp", "words\\(DefectKind"))
        self.assertEqual([name.replace("_", "-") for name in kinds], named)

    def test_rules_of_verify(self):
        for name in enum("verification.h", "Rule"):
            self.row(name, "4: unsolved")

    def test_witnesses(self):
        rules = text("src", "certificates", "rules.h")
        named = re.findall(r'inline const char\* name\(const (\w+)&\) \{ return "([a-z]+)"; \}', rules)
        kinds = re.search(r"std::variant<(.*?)>;", text("include", "overtet", "certificate.h"), re.DOTALL).group(1)
        kinds = [kind.strip() for kind in kinds.split(",")]
        self.assertEqual(sorted(kind for kind, _ in named), sorted(kind for kind in kinds if kind != "CustomCertificate"))
        self.assertIn("`CustomCertificate`", self.faq)
        section = self.section("5: infeasible")
        for kind, name in named:
            with self.subTest(kind):
                row = re.search(rf"(?m)^\| `{name}` \|.*$", section)
                self.assertTrue(row, f"the FAQ has no row for the rule {name}")
                branch = re.search(rf"forbids_branch_lines\(const {kind}&\) {{ return (true|false); }}", rules).group(1)
                if branch == "true":
                    self.assertNotIn("*subdividing*", row.group(0), "refine and branch cannot help there")

    def said(self, statement, where):
        """The FAQ quotes one of the pieces that a message is made of."""
        pieces = [plain(piece) for piece in literals(statement)]
        pieces = [piece for piece in pieces if len(piece) >= 16] or pieces
        self.assertTrue(any(self.quotes(piece) for piece in pieces), f"{where}: the FAQ does not have: {' | '.join(pieces)}")

    def quotes(self, piece):
        faq = plain(self.faq)
        words = piece.split()
        # Most of a sentence that goes on will do.
        return piece in faq or (len(words) > 6 and any(" ".join(words[k:k + 6]) in faq for k in range(len(words) - 5)))

    def test_advice(self):
        body = words_of("src/certificates/diagnose.cpp", "advise\\(Diagnosis")
        statements = [s for s in re.findall(r"say\((.*?)\);\n", body, re.DOTALL) if '"' in s]
        self.assertGreaterEqual(len(statements), 8)
        for statement in statements:
            with self.subTest(statement[:60]):
                self.said(statement, "advice")

    def test_warnings(self):
        found = 0
        for path in glob.glob(os.path.join(ROOT, "src", "**", "*.cpp"), recursive=True):
            with open(path, encoding="utf-8") as file:
                code = file.read()
            for statement in re.findall(r"note\(\s*LogLevel::warning,(.*?)\);\n", code, re.DOTALL):
                found += 1
                with self.subTest(os.path.relpath(path, ROOT)):
                    self.said(statement, path)
        self.assertGreaterEqual(found, 10)


if __name__ == "__main__":
    unittest.main()
