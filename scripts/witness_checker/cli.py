"""The command line: two files, one sentence, an exit code."""

import sys

from . import __doc__ as usage
from .errors import Refuted, Undecided, Unreadable
from .report import check

CONFIRMED, REFUTED, UNREADABLE, UNDECIDED = 0, 1, 2, 3


def main(arguments):
    if len(arguments) != 2 or arguments[0] in ("-h", "--help"):
        print(usage.strip(), file=sys.stderr)
        return UNREADABLE
    try:
        print("Confirmed: " + check(*arguments) + ".")
        return CONFIRMED
    except Refuted as e:
        print(f"Refuted: {e}.")
        return REFUTED
    except Unreadable as e:
        print(f"Unreadable: {e}.", file=sys.stderr)
        return UNREADABLE
    except Undecided as e:
        print(f"Undecided: {e}.", file=sys.stderr)
        return UNDECIDED
