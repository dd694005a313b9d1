#!/usr/bin/env python3
"""Validates reports against docs/report.schema.json.

usage: validate_reports.py SCHEMA REPORT.json ...

Prints a line for each thing that is wrong; exit code 1 if there is any. Besides the schema: what is counted is
listed (moved vertices, B0 of the vertices), and a witness has a position for each vertex that it names.
"""
import json
import sys

import jsonschema


def complaints(report, validator):
    for error in validator.iter_errors(report):
        yield "%s: %s" % ("/".join(map(str, error.absolute_path)) or "top", error.message)
    moved = report.get("moved", {})
    if moved.get("vertices") != len(moved.get("ids", [])):
        yield "moved: %r vertices, %d ids" % (moved.get("vertices"), len(moved.get("ids", [])))
    witness = report.get("witness", {})
    vertices = witness.get("vertices", [])
    for key in ("B0", "moves") + (("positions",) if witness.get("rule") != "stack" else ()):
        if "vertices" in witness and key in witness and len(witness[key]) != len(vertices):
            yield "witness: %d vertices, %d %s" % (len(vertices), len(witness[key]), key)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        schema = json.load(file)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    wrong = 0
    for path in sys.argv[2:]:
        with open(path, encoding="utf-8") as file:
            report = json.load(file)
        for complaint in complaints(report, validator):
            print("%s: %s" % (path, complaint))
            wrong += 1
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
