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
from contextlib import ExitStack, contextmanager, suppress
from types import FrameType
from typing import Any, NoReturn

import plumbob
from plumbob.models.memory import UNMAPPED

LONGEST_WORD = 300  # longest word in a message, in characters
USAGE, INCOMPLETE_RUN, DEFECT, INTERRUPTED = 2, 3, 4, 130
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
    "difference",
    "compare",
    "releases",
    "sweep",
    "worst",
    "merge",
    "identify",
    "plan",
    "view",
    "models",
    "check-engine",
    "sources",
    "cite",
)


class _Parser(argparse.ArgumentParser):
    """An argument parser that reports errors in one line."""

    def error(self, message: str) -> NoReturn:
        """Prints one line and exits with the code for wrong use."""
        self.exit(USAGE, f"{self.prog}: {_one_line(message)} (see `{self.prog} --help`)\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the command line `argv` and returns the exit code: 0 if all is as expected, 1 for an
    unexpected verdict, 2 for wrong use, bad input or a stdout that takes no results, 3 for a
    missing engine or an incomplete study, 4 for a defect of plumbob itself, 130 when
    interrupted."""
    with _escaping_streams() as closed, _raised_interrupts() as interrupts:
        if closed:
            return _report(USAGE, "stdout is closed: results have no place to go")
        return _run_with_exit_code(argv, interrupts)


def _run_with_exit_code(argv: Sequence[str] | None, interrupts: Sequence[int]) -> int:
    """Runs the command line; returns its exit code, or the exit code of the error that ends it.
    `interrupts` are the numbers of the interrupts so far."""
    from plumbob.analytic.parameters import ParameterError

    try:
        try:
            return _run_command(argv)
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        return 0
    except KeyboardInterrupt as error:
        return _report(INTERRUPTED, "interrupted", error)
    except SystemExit:
        raise
    except BaseException as error:
        # A library that is interrupted while it loads may raise another error.
        if interrupts:
            return _report(INTERRUPTED, "interrupted", error)
        if isinstance(error, ParameterError):
            return _report(USAGE, str(error), error)
        if _lacks_memory(error):
            return _report(INCOMPLETE_RUN, "out of memory", error)
        if isinstance(error, OSError):
            file = f"{error.filename}: " if error.filename else ""
            return _report(USAGE, f"{file}{error.strerror or error}", error)
        return _report(DEFECT, f"a defect of plumbob itself: {_error_text(error)}", error)


def _run_command(argv: Sequence[str] | None) -> int:
    """Runs the command of a command line; returns its exit code."""
    from plumbob.reports.commands.arguments.options import read_values

    words = list(sys.argv[1:] if argv is None else argv)
    known_first = [word for word in words[:1] if word in (*COMMANDS, "--version")]
    top = parser(known_first or COMMANDS, words)
    complete_words(top)
    if words and not known_first and not words[0].startswith("-"):
        hint = _did_you_mean([words[0]], COMMANDS)
        top.error(f"there is no command {words[0]!r}{hint}")
    arguments, unknown = top.parse_known_args(words)
    own_parser: argparse.ArgumentParser = vars(arguments).pop("own_parser")
    if unknown:
        options = [name for action in own_parser._actions for name in action.option_strings]
        hint = _did_you_mean(unknown, options)
        own_parser.error(f"unrecognized arguments: {' '.join(unknown)}{hint}")
    read_values(arguments)
    # Arguments may hold bytes that are not UTF-8.
    line = shlex.join(["plumbob", *words]).encode("utf-8", "backslashreplace")
    arguments.line = line.decode()
    return int(arguments.command(arguments))


def _did_you_mean(words: Sequence[str], names: Sequence[str]) -> str:
    """Returns a question that names what is most like some unknown words; empty if nothing is."""
    import difflib

    typed = [word.partition("=")[0] for word in words]
    similar = [difflib.get_close_matches(word, names, n=1) for word in typed]
    found = dict.fromkeys(name for matches in similar for name in matches)
    return f": did you mean {' and '.join(found)}?" if found else ""


def _lacks_memory(error: BaseException) -> bool:
    """Whether an error comes from a lack of memory, for example while a library loads. Imports
    nothing, as memory may be exhausted."""
    unmapped = isinstance(error, ImportError) and UNMAPPED in str(error)
    refused = isinstance(error, OSError) and error.errno == errno.ENOMEM
    return unmapped or refused or isinstance(error, MemoryError)


def _report(code: int, message: str, error: BaseException | None = None) -> int:
    """Prints the message and the error's notes in one line; returns `code`."""
    text = "; ".join([message, *getattr(error, "__notes__", ())])
    print(f"plumbob: {_one_line(text)}", file=sys.stderr)
    return code


def _one_line(text: str) -> str:
    """Returns a text as one line; the ends of words longer than LONGEST_WORD are left out. Imports
    nothing, as memory may be exhausted."""
    words = []
    for word in text.split():
        words.append(word if len(word) <= LONGEST_WORD else f"{word[:LONGEST_WORD]}...")
    return " ".join(words)


def _error_text(error: BaseException) -> str:
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


class _SafeStream:
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
def _escaping_streams() -> Iterator[bool]:
    """Makes stdout and stderr escape characters that the terminal's encoding lacks; yields whether
    stdout is closed. The null device replaces a closed stream. Otherwise the next file that is
    opened would get the printed text."""
    before: tuple[Any, Any] = sys.stdout, sys.stderr
    with ExitStack() as null_devices:
        streams: list[Any] = []
        for stream in before:
            if stream is None:
                stream = null_devices.enter_context(open(os.devnull, "w", encoding="utf-8"))
            if isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")
            streams.append(stream)
        stdout: Any = _SafeStream(streams[0], "stdout")
        stderr: Any = _SafeStream(streams[1])
        sys.stdout, sys.stderr = stdout, stderr
        try:
            yield before[0] is None
        finally:
            sys.stdout, sys.stderr = before


@contextmanager
def _raised_interrupts() -> Iterator[list[int]]:
    """Raises each interrupt (SIGINT, SIGTERM) as KeyboardInterrupt; yields a list to which each
    interrupt's number is added."""
    numbers: list[int] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        numbers.append(number)
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield numbers
        return
    # A background job may be started with interrupts ignored: such handlers stay.
    default_handlers = (signal.default_int_handler, signal.SIG_DFL)
    before: dict[signal.Signals, Any] = {}
    for number in (signal.SIGINT, signal.SIGTERM):
        handler = signal.getsignal(number)
        if handler in default_handlers:
            before[number] = handler
    for number in before:
        signal.signal(number, interrupt)
    try:
        yield numbers
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _version_text(wanted: Sequence[str]) -> str:
    """Returns the text that `--version` prints. It is looked up only if asked for, since this takes
    as long as a short command."""
    return f"plumbob {plumbob.__version__}" if "--version" in wanted else "plumbob"


def complete_words(top: argparse.ArgumentParser) -> None:
    """Answers a shell that asks for completions, and ends the process then, if argcomplete is
    installed. The variable _ARGCOMPLETE is set by the shell's completion script alone, so that
    other commands need not load argcomplete."""
    if "_ARGCOMPLETE" in os.environ:
        with suppress(ImportError):
            import argcomplete

            argcomplete.autocomplete(top)


def parser(wanted: Sequence[str], words: Sequence[str] = ()) -> argparse.ArgumentParser:
    """Returns the parser of the commands `wanted`; only the modules of these commands are loaded.
    `words` are those of the command line, whose scene --help describes."""
    from plumbob.reports.commands.arguments.options import declare

    top = _Parser(prog="plumbob", description="Holds physics engines against exact answers.")
    top.add_argument("--version", action="version", version=_version_text(wanted))
    commands = top.add_subparsers(metavar="COMMAND", required=True, parser_class=_Parser)
    for name in wanted:
        if name not in COMMANDS:
            continue
        # The module of `list` has another name than the builtin function.
        module_name = "list_" if name == "list" else name.replace("-", "_")
        module = importlib.import_module(f"plumbob.reports.commands.{module_name}")
        description = (module.__doc__ or "").partition(": ")[2].strip().rstrip(".")
        command = commands.add_parser(name, help=description, description=f"{description}.")
        declare(command, name, module, words)
        command.set_defaults(command=module.command, own_parser=command)
    return top


if __name__ == "__main__":
    sys.exit(main())
