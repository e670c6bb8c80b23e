"""The border: what a file, a model, a policy, a package or an engine raises becomes one line.

A block at the border holds a call of what is not plumbob's. Inside nothing is caught, so that an
error of plumbob's own stays a defect.
"""

from __future__ import annotations

import signal
import traceback
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from plumbob.analytic.parameters import ParameterError

LONGEST = 160  # characters of an error's line: two lines of a terminal
LARGEST_FILE = 10_000_000  # [bytes]: far more than a model file without meshes has


class Refused(Exception):
    """What the other side of a border raised, in one line."""


@contextmanager
def border(
    refused: Callable[[str], BaseException] = Refused, *passing: type[BaseException]
) -> Iterator[None]:
    """Raise `refused` with one line, whatever the block raises. Errors of the kinds `passing`,
    interrupts and exhausted memory pass the border unchanged."""
    unchanged: tuple[type[BaseException], ...] = (KeyboardInterrupt, MemoryError, *passing)
    try:
        yield
    except BaseException as error:
        if isinstance(error, unchanged) or _of_signal(error):
            raise
        raise refused(one_line(error)) from None


def must_be(
    what: str, name: str, value: object, *passing: type[BaseException]
) -> AbstractContextManager[None]:
    """A border that raises ParameterError: the argument `name`, of this value, must be `what`."""
    return border(lambda line: ParameterError(name, value, f"{what} ({line})"), *passing)


def regular(name: str, file: Path, most: float = LARGEST_FILE) -> Path:
    """`file`, given as the argument `name`, if it is a regular file of at most so many bytes, links
    followed; raises ParameterError. Nothing is opened: a pipe without a writer would never be."""
    with must_be("a file that can be read", name, str(file)):
        there = file.exists()
        fits = file.is_file() and file.stat().st_size <= most
    if not there:
        raise ParameterError(name, str(file), "a file that exists")
    if not fits:
        raise ParameterError(name, str(file), f"a regular file of at most {most:.0f} bytes")
    return file


def _of_signal(error: BaseException) -> bool:
    """Whether the handler of a signal has raised an error, as a caller's own may end the process
    by SystemExit."""
    handlers = map(signal.getsignal, signal.valid_signals())
    codes = {getattr(handler, "__code__", None) for handler in handlers} - {None}
    return any(frame.f_code in codes for frame, _ in traceback.walk_tb(error.__traceback__))


def one_line(error: BaseException) -> str:
    """The kind and the words of an error in one line; an error without words that can be read says
    where it was raised."""
    kind = type(error).__name__
    frames = traceback.extract_tb(error.__traceback__)
    place = f"raised in {frames[-1].name}" if frames else "no words"
    words = f"{kind}: {words_of(error) or place}"
    return shortened(" ".join(words.split()))


def words_of(error: BaseException) -> str:
    """The words of an error; empty where asking for them raises another."""
    try:
        return str(error)
    except KeyboardInterrupt:
        raise
    except BaseException:
        return ""


def shortened(text: str, most: int = LONGEST) -> str:
    """A text of at most so many characters, its end replaced by dots."""
    return text if len(text) <= most else f"{text[: most - 3]}..."
