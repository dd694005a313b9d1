"""What keeps a model or a file from being used."""


class NoModel(Exception):
    """A kind found no model with these random numbers; it tries others."""


class Unreadable(Exception):
    """A file does not hold what it should."""
