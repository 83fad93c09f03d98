"""Errors that a command tells its caller in one line."""


class Unusable(Exception):
    """What was given cannot be used; the text says what and why."""


class RunFailed(Exception):
    """A run of the program did not end well; the text says which and what it printed last."""
