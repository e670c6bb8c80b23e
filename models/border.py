"""The border to code that is not plumbob's: an error of a file, a model, a policy, a package or an
engine becomes one line.

Each block at the border holds one call of foreign code. Errors of plumbob's own code are caught
nowhere: they are defects.
"""

from __future__ import annotations

import signal
import traceback
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from plumbob.analytic.parameters import ParameterError

LONGEST_LINE = 160  # characters in an error's line: two lines of a terminal
LARGEST_FILE = 10_000_000  # [bytes] largest model file: far more than one without meshes has


class Refused(Exception):
    """An error that foreign code raised in a block at the border, in one line."""


@contextmanager
def border(
    refused: Callable[[str], BaseException] = Refused, *passing: type[BaseException]
) -> Iterator[None]:
    """Raises `refused` with one line in place of any error of the block. Interrupts, exhausted
    memory and errors of the kinds `passing` are raised unchanged."""
    unchanged: tuple[type[BaseException], ...] = (KeyboardInterrupt, MemoryError, *passing)
    try:
        yield
    except BaseException as error:
        if isinstance(error, unchanged) or _raised_by_signal(error):
            raise
        raise refused(one_line(error)) from None


def must_be(
    what: str, name: str, value: object, *passing: type[BaseException]
) -> AbstractContextManager[None]:
    """Returns a border that raises ParameterError: the argument `name`, which has this `value`,
    must be `what`."""
    return border(lambda line: ParameterError(name, value, f"{what} ({line})"), *passing)


def regular_file(name: str, file: Path, most: float = LARGEST_FILE) -> Path:
    """Returns `file`, given as the argument `name`, if it is a regular file, or a link to one, of
    at most `most` bytes; otherwise raises ParameterError. The file is not opened: opening a pipe
    that nobody writes to takes forever."""
    with must_be("a file that can be read", name, str(file)):
        exists = file.exists()
        is_regular = file.is_file() and file.stat().st_size <= most
    if not exists:
        raise ParameterError(name, str(file), "a file that exists")
    if not is_regular:
        raise ParameterError(name, str(file), f"a regular file of at most {most:.0f} bytes")
    return file


def _raised_by_signal(error: BaseException) -> bool:
    """Whether a signal handler raised an error: a caller's own handler may end the process by
    SystemExit."""
    handlers = [signal.getsignal(number) for number in signal.valid_signals()]
    codes = {getattr(handler, "__code__", None) for handler in handlers} - {None}
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    return any(frame.f_code in codes for frame in frames)


def one_line(error: BaseException) -> str:
    """Returns the kind of an error and its message in one line. If the message is empty or cannot
    be read, the place where the error was raised replaces it."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f"raised in {frames[-1].name}" if frames else "no message"
    return shortened(f"{type(error).__name__}: {message_of(error) or place}")


def message_of(error: BaseException) -> str:
    """Returns the message of an error; empty if reading it raises another error."""
    try:
        return str(error)
    except KeyboardInterrupt:
        raise
    except BaseException:
        return ""


def shortened(text: str, most: int = LONGEST_LINE) -> str:
    """Returns a text in one line of at most `most` characters: dots replace the end of a longer
    text."""
    line = " ".join(text.split())
    return line if len(line) <= most else f"{line[: most - 3]}..."
