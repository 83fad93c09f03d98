"""Many runs of the solver, side by side where time is not measured."""

from __future__ import annotations

import functools
import itertools
import pathlib
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, TypeVar

from .. import options as option_words
from .. import runs, states, tables
from ..options import Options
from ..problems import RunFailed
from ..runs import Printed
from ..states import State

Method = TypeVar("Method", bound=Callable[..., Any])
Item = TypeVar("Item")
Result = TypeVar("Result")


def kept(method: Method) -> Method:
    """Each result is computed once, by whichever thread asks first."""
    results: dict[Any, Future[Any]] = {}
    lock = threading.Lock()

    @functools.wraps(method)
    def once(self: Any, options: Options, *more: Any, **named: Any) -> Any:
        key = (tuple(sorted((k, str(v)) for k, v in options.items())), more, tuple(named.items()))
        with lock:
            first = key not in results
            future = results.setdefault(key, Future())
        if first:
            try:
                future.set_result(method(self, options, *more, **named))
            except BaseException as error:
                future.set_exception(error)
        return future.result()
    return once  # type: ignore[return-value]


class Program:
    """One rank and one thread at a time;
    `workers` of them side by side where time is not measured."""

    def __init__(self, folder: pathlib.Path, workers: int) -> None:
        self.folder = pathlib.Path(folder).resolve()
        self.folder.mkdir(parents=True, exist_ok=True)
        self.workers = workers
        self.count = itertools.count()

    def run(self, options: Options, *more: str) -> Printed:
        if options.get("pair_points"):
            # Settings without far points have none, whatever the default.
            options = {"pair_far_points": options["pair_points"], **options}
        words = [*option_words.words(options), *more]
        done = runs.run(words)
        if done.returncode:
            raise RunFailed(f"nanoweft {' '.join(words)}: {done.stderr.strip()[-400:]}")
        return Printed(done.stdout)

    @kept
    def final(self, options: Options, forces: bool = False) -> tuple[State, Printed]:
        """The final state (forces and torques too if asked for), and what was printed."""
        file = self.folder / f"final{next(self.count)}.h5"
        more: Options = {"state_forces": None} if forces else {}
        printed = self.run({**options, "state_output": file, **more})
        state = states.read(file)
        file.unlink()
        return state, printed

    def table(self, options: Options) -> tuple[tables.Table, Printed, State]:
        """The energy table, what was printed, the final state."""
        file = self.folder / f"energy{next(self.count)}.csv"
        state, printed = self.final({**options, "energy_monitor": f"ascii:{file}"})
        rows = tables.read(file)
        file.unlink()
        return rows, printed, state

    def each(self, work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
        """`work` for every item, side by side, results in order."""
        with ThreadPoolExecutor(self.workers) as pool:
            return list(pool.map(work, items))
