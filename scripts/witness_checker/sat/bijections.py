"""Bijections as unknowns of a formula.

A bijection of n things to n things is a square of literals: in row a and column b whether a goes to b.
"""

from .formula import FALSE, TRUE


def identity(n):
    return [[TRUE if a == b else FALSE for b in range(n)] for a in range(n)]


def unknown(formula, n, may=lambda a, b: True):
    """Any bijection in which a goes to b only where it may."""
    square = [[formula.new() if may(a, b) else FALSE for b in range(n)] for a in range(n)]
    for line in [*square, *inverse(square)]:
        formula.exactly_one(line)
    return square


def inverse(square):
    return [list(column) for column in zip(*square)]


def with_fixed(square):
    """The bijection of one thing more, which stays what it is."""
    n = len(square)
    return [[*row, FALSE] for row in square] + [[FALSE] * n + [TRUE]]


def known(square):
    """Where each thing goes, if that is known already; otherwise None."""
    if any(x not in (TRUE, FALSE) for row in square for x in row):
        return None
    return [row.index(TRUE) for row in square]


def then(formula, first, second):
    """The first bijection, and then the second one."""
    if (ways := known(first)) is not None:
        return [second[b] for b in ways]
    if (ways := known(inverse(second))) is not None:
        return [[row[b] for b in ways] for row in first]
    n = len(first)
    both = unknown(formula, n)
    for a in range(n):
        for b in range(n):
            for c in range(n):
                formula.same((first[a][b],), second[b][c], both[a][c])
    return both


def equal(formula, first, second):
    for row, other in zip(first, second):
        for x, y in zip(row, other):
            formula.same((), x, y)
