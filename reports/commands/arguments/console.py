"""Output of a command beside its result: a progress bar, notes on stderr, and the folder of
results."""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study.scheduler import Progress

WIDTH_FOR_BAR = 60  # [columns] smallest width of a terminal with a progress bar


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
def progress(
    budget: float | None = None, lines: bool = False, above: Sequence[str] = ()
) -> Iterator[Progress]:
    """Gives a function that shows on stderr how far a command is. Its arguments are the description
    of a task, the number of finished tasks and the number of all tasks; no number of tasks means
    that it is unknown. With a `budget` [s], the processor time that is spent of it stands beside
    the task; the lines `above`, to which the caller may add some, stand above it until the command
    ends. If stderr is no terminal, the function does nothing; with `lines`, it prints a line for
    each finished task."""
    if not sys.stderr.isatty():
        yield _print_finished if lines else lambda what, done, total: None
        return
    from rich import progress as rich
    from rich.console import Console, RenderableType
    from rich.table import Column
    from rich.text import Text

    begin = time.process_time()

    class TimeColumn(rich.ProgressColumn):
        """The time that has passed, or that is spent of the budget."""

        def render(self, task: rich.Task) -> Text:
            """Returns the text of the column."""
            if budget is None:
                return Text(f"{task.elapsed or 0.0:.0f} s")
            return Text(f"{time.process_time() - begin:.0f} of {budget:g} s")

    class Bar(rich.Progress):
        """The line of progress, with the lines above it."""

        def get_renderables(self) -> Iterator[RenderableType]:
            """Yields the lines and the bar."""
            yield from (Text(line) for line in above)
            yield from super().get_renderables()

    console = Console(stderr=True)
    # The description is cut where the terminal is narrow.
    description = Column(ratio=1, no_wrap=True, overflow="ellipsis")
    columns: list[rich.ProgressColumn] = [
        rich.TextColumn("{task.description}", table_column=description, markup=False)
    ]
    if console.width >= WIDTH_FOR_BAR:
        columns.append(rich.BarColumn(bar_width=20))
    columns.append(TimeColumn())
    with Bar(
        *columns,
        console=console,
        expand=True,
        transient=True,
        # If stdout is a pipe, lines that are printed meanwhile have to go into the pipe.
        redirect_stdout=sys.stdout.isatty(),
    ) as bar:
        task = bar.add_task("", total=None)

        def show(what: str, done: int, total: int) -> None:
            counted = f"{done} of {total}: {what}" if total else what
            bar.update(task, description=counted, completed=done, total=total or None)

        yield show


def _print_finished(what: str, done: int, total: int) -> None:
    """Prints a line for a finished task, if the number of all tasks is known."""
    if total:
        note(f"{done} of {total}: {what}")
