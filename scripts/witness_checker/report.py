"""The witness of a report, and the rule that checks it."""

import json

from .errors import Unreadable
from .files import read_surface
from .geometry.surface import Surface
from .rules import area, crowded, fold, gluing, link, shared, stack, unpaired, vertex, winding

RULES = {
    "area": area,
    "winding": winding,
    "vertex": vertex,
    "fold": fold,
    "unpaired": unpaired,
    "crowded": crowded,
    "link": link,
    "shared": shared,
    "stack": stack,
    "gluing": gluing,
}


def check(surface_path, report_path):
    """What has been confirmed, as a sentence."""
    witness = read_witness(report_path)
    surface = Surface(*read_surface(surface_path))
    rule = rule_of(witness)
    if rule not in RULES:
        raise Unreadable(f"{report_path}: the rule of the witness is unknown")
    if "apart" in witness and rule != "unpaired":
        raise Unreadable("a witness of this rule cannot have the key 'apart'")
    return RULES[rule].check(surface, witness)


def read_witness(path):
    try:
        with open(path, encoding="utf-8") as file:
            report = json.load(file)
    except (OSError, ValueError) as e:
        raise Unreadable(f"{path}: {e}") from e
    if not isinstance(report, dict):
        raise Unreadable(f"{path}: not a report")
    witness = report.get("witness", report if "status" not in report else None)
    if not isinstance(witness, dict):
        raise Unreadable(f"{path}: has no witness")
    return witness


def rule_of(witness):
    """Witnesses of the oldest two rules need not name them."""
    if "point" in witness:
        return "winding"
    rule = witness.get("rule")
    return "vertex" if rule is None and "vertex" in witness else rule
