"""The command `plumbob`: its arguments, and the exit codes of its errors."""

from __future__ import annotations

import argparse
import errno
import importlib
import io
import os
import shlex
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from types import FrameType
from typing import Any, NoReturn

import plumbob
from plumbob.models.memory import UNMAPPED

MOST_SHOWN = 300  # longest word in a message, in characters
USAGE, INCOMPLETE, DEFECT, INTERRUPTED = 2, 3, 4, 130
COMMANDS = (
    "list",
    "validate",
    "report",
    "solve",
    "run",
    "recommend",
    "settings",
    "audit",
    "stability",
    "gradient",
    "compare",
    "sweep",
    "worst",
    "identify",
    "plan",
    "models",
    "check-engine",
    "sources",
    "cite",
)


class _Parser(argparse.ArgumentParser):
    """An argument parser that reports errors in one line."""

    def error(self, message: str) -> NoReturn:
        """Prints one line and exits with the code for wrong use."""
        self.exit(USAGE, f"{self.prog}: {_line(message)} (see `{self.prog} --help`)\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the command line `argv` and returns the exit code: 0 if all is as expected, 1 for an
    unexpected verdict, 2 for wrong use, bad input or a stdout that takes no results, 3 for a
    missing engine or an incomplete study, 4 for a defect of plumbob itself, 130 when
    interrupted."""
    with _streams() as closed, _interrupts() as interrupts:
        if closed:
            return _said(USAGE, "stdout is closed: results have no place to go")
        return _outcome(argv, interrupts)


def _outcome(argv: Sequence[str] | None, interrupts: Sequence[int]) -> int:
    """Runs the command line; returns its exit code, or the exit code of the error that ends it."""
    from plumbob.analytic.parameters import ParameterError

    try:
        try:
            return _command(argv)
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        return 0
    except KeyboardInterrupt as error:
        return _said(INTERRUPTED, "interrupted", error)
    except SystemExit:
        raise
    except BaseException as error:
        # A library that is interrupted while it loads may raise another error.
        if interrupts:
            return _said(INTERRUPTED, "interrupted", error)
        if isinstance(error, ParameterError):
            return _said(USAGE, str(error), error)
        if _lacks_memory(error):
            return _said(INCOMPLETE, "out of memory", error)
        if isinstance(error, OSError):
            where = f"{error.filename}: " if error.filename else ""
            return _said(USAGE, f"{where}{error.strerror or error}", error)
        return _said(DEFECT, f"a defect of plumbob itself: {_described(error)}", error)


def _command(argv: Sequence[str] | None) -> int:
    """Runs the command of a command line; returns its exit code."""
    from plumbob.reports.commands.arguments.options import read

    words = list(sys.argv[1:] if argv is None else argv)
    first = [word for word in words[:1] if word in (*COMMANDS, "--version")]
    chosen = parser(first or COMMANDS).parse_args(words)
    read(chosen)
    # Arguments may hold bytes that are not UTF-8.
    line = shlex.join(["plumbob", *words]).encode("utf-8", "backslashreplace")
    chosen.line = line.decode()
    return int(chosen.command(chosen))


def _lacks_memory(error: BaseException) -> bool:
    """Whether an error comes from a lack of memory, for example while a library loads. Imports
    nothing, as memory may be exhausted."""
    unmapped = isinstance(error, ImportError) and UNMAPPED in str(error)
    refused = isinstance(error, OSError) and error.errno == errno.ENOMEM
    return unmapped or refused or isinstance(error, MemoryError)


def _said(code: int, message: str, error: BaseException | None = None) -> int:
    """Prints the message and the error's notes in one line; returns `code`."""
    text = "; ".join([message, *getattr(error, "__notes__", ())])
    print(f"plumbob: {_line(text)}", file=sys.stderr)
    return code


def _line(text: str) -> str:
    """Returns a text as one line; the ends of words longer than MOST_SHOWN are left out. Imports
    nothing, as memory may be exhausted."""
    words = (w if len(w) <= MOST_SHOWN else f"{w[:MOST_SHOWN]}..." for w in text.split())
    return " ".join(words)


def _described(error: BaseException) -> str:
    """Returns the kind of an error, and the file that its traceback is written to."""
    import tempfile
    import traceback

    from plumbob.models.border import one_line

    lines = "".join(traceback.format_exception(error))
    kind = one_line(error)
    try:
        handle, name = tempfile.mkstemp(prefix="plumbob-defect-", suffix=".txt")
        with open(handle, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write(f"{sys.argv}\n{lines}")
    except OSError:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        return f"{kind} ({frame.filename}:{frame.lineno}; no traceback could be written)"
    return f"{kind} (traceback in {name})"


class _Printed:
    """A stream to print on that survives write errors. After an error it drops everything that is
    still printed. If the stream has a `name`, the error is raised with that name. A stream without
    a name raises nothing: no exit code depends on it."""

    def __init__(self, stream: Any, name: str = "") -> None:
        self._stream, self._name = stream, name

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Writes a text; returns its length."""
        with self._errors():
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Writes the text that waits in a buffer."""
        with self._errors():
            self._stream.flush()

    @contextmanager
    def _errors(self) -> Iterator[None]:
        """Handles an error of the stream: sends further output to the null device."""
        try:
            yield
        except OSError as error:
            os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())
            if self._name:
                error.filename = self._name
                raise


@contextmanager
def _streams() -> Iterator[bool]:
    """Makes stdout and stderr escape characters that the terminal's encoding lacks; yields whether
    stdout is closed. The null device replaces a closed stream. Otherwise the next file that is
    opened would get the printed text."""
    before: tuple[Any, Any] = sys.stdout, sys.stderr
    with ExitStack() as opened:
        out, err = (
            opened.enter_context(open(os.devnull, "w", encoding="utf-8")) if s is None else s
            for s in before
        )
        for stream in (out, err):
            if isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")
        printed: Any = _Printed(out, "stdout"), _Printed(err)
        sys.stdout, sys.stderr = printed
        try:
            yield before[0] is None
        finally:
            sys.stdout, sys.stderr = before


@contextmanager
def _interrupts() -> Iterator[list[int]]:
    """Raises each interrupt (SIGINT, SIGTERM) as KeyboardInterrupt; yields a list to which each
    interrupt's number is added."""
    signals: list[int] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        signals.append(number)
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield signals
        return
    # A background job may be started with interrupts ignored: such handlers stay.
    now = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    usual = (signal.default_int_handler, signal.SIG_DFL)
    before = {number: handler for number, handler in now.items() if handler in usual}
    for number in before:
        signal.signal(number, interrupt)
    try:
        yield signals
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _version(wanted: Sequence[str]) -> str:
    """Returns the text that `--version` prints. It is looked up only if asked for, since this takes
    as long as a short command."""
    return f"plumbob {plumbob.__version__}" if "--version" in wanted else "plumbob"


def parser(wanted: Sequence[str]) -> argparse.ArgumentParser:
    """Returns the parser of the commands `wanted`; only the modules of these commands are
    loaded."""
    from plumbob.reports.commands.arguments.options import declare

    top = _Parser(prog="plumbob", description="Holds physics engines against exact answers.")
    top.add_argument("--version", action="version", version=_version(wanted))
    commands = top.add_subparsers(metavar="COMMAND", required=True, parser_class=_Parser)
    for name in (name for name in wanted if name in COMMANDS):
        module = importlib.import_module(
            f"plumbob.reports.commands.{name.replace('-', '_')}{'_' if name == 'list' else ''}"
        )
        described = (module.__doc__ or "").partition(": ")[2].strip().rstrip(".")
        command = commands.add_parser(name, help=described, description=f"{described}.")
        declare(command, name, module)
        command.set_defaults(command=module.command)
    return top


if __name__ == "__main__":
    sys.exit(main())
