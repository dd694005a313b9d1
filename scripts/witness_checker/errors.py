"""The ways in which a check ends without a proof."""


class Unreadable(Exception):
    """The files do not say what is to be checked."""


class Refuted(Exception):
    """The witness is not a proof."""


class Undecided(Exception):
    """Whether the witness is a proof was not found out: a tool is missing, or its answer does not hold."""


class Grazed(Exception):
    """A direction meets an edge: another one is needed."""
