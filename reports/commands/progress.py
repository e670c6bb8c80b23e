"""Progress on a terminal's stderr; silence elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from plumbob.engines.study.runner import Progress


@contextmanager
def progress() -> Iterator[Progress]:
    """A function that shows what is being done, how much is done, and of how much."""
    if not sys.stderr.isatty():
        yield lambda what, done, total: None
        return
    from rich import progress as rich
    from rich.console import Console

    bar = rich.Progress(
        rich.TextColumn("{task.description:<56}"), rich.BarColumn(), rich.MofNCompleteColumn(),
        console=Console(stderr=True), transient=True,
    )  # fmt: skip
    with bar:
        task = bar.add_task("", total=None)

        def show(what: str, done: int, total: int) -> None:
            bar.update(task, description=what[:56], completed=done, total=total or None)

        yield show
