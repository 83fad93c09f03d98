"""Errors that a command tells its caller in one line, and how a command ends."""
from __future__ import annotations

import os
import pathlib
import signal
import sys
from typing import Callable, NoReturn


class Unusable(Exception):
    """What was given cannot be used; the text says what and why."""


class RunFailed(Exception):
    """A run of the program did not end well; the text says which and what it printed last."""


def command(main: Callable[[], int | None]) -> NoReturn:
    """Run the main function of a command and end with the status that it returns.

    A problem, also one with a file, becomes one line, "command: what and why", and status 1. A
    reader that has left (a pipe to `head`) ends the command without a word, with the status that a
    shell shows for SIGPIPE.
    """
    try:
        try:
            status = main()
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        # Python flushes once more as it ends, and would complain then.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(128 + signal.SIGPIPE)
    except (Unusable, RunFailed, OSError) as problem:
        sys.exit(f"{pathlib.Path(sys.argv[0]).stem}: {problem}")
    sys.exit(status)
