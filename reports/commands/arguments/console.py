"""Output of a command beside its result: a progress bar, notes on stderr, and the folder of
results."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study.scheduler import Progress


def note(line: str) -> None:
    """Prints a line for the user on stderr."""
    print(f"plumbob: {line}", file=sys.stderr)


def writable_folder(name: str, folder: Path) -> Path:
    """Returns `folder` if a file can be written into it; creates the folder if it does not exist.
    Otherwise raises ParameterError for the argument `name`."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        wanted = f"a folder to write to ({error.strerror})"
        raise ParameterError(name, str(folder), wanted) from None


@contextmanager
def progress() -> Iterator[Progress]:
    """Gives a function that shows a progress bar on stderr. Its arguments are the description of a
    task, the number of finished tasks and the number of all tasks. If stderr is no terminal, the
    function does nothing."""
    if not sys.stderr.isatty():
        yield lambda what, done, total: None
        return
    from rich import progress as rich
    from rich.console import Console

    bar = rich.Progress(
        rich.TextColumn("{task.description:<56}"),
        rich.BarColumn(),
        rich.MofNCompleteColumn(),
        console=Console(stderr=True),
        transient=True,
        # If stdout is a pipe, lines that are printed meanwhile have to go into the pipe.
        redirect_stdout=sys.stdout.isatty(),
    )
    with bar:
        task = bar.add_task("", total=None)

        def show(what: str, done: int, total: int) -> None:
            bar.update(task, description=what[:56], completed=done, total=total or None)

        yield show
