"""Engines and systems that other installed packages add by entry points. They are loaded when a
name is asked for that plumbob itself does not have. A broken package costs a line on stderr, not
the study."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from types import MappingProxyType
from typing import Any

from plumbob.models.border import Refused, border, shortened

ENGINES, SYSTEMS = "plumbob.engines", "plumbob.systems"  # groups of entry points

# Returns the reason why an object with a name is not valid; empty if it is valid.
Wrong = Callable[[Any, str], str]


@dataclass(frozen=True)
class Addition:
    """An object that a package adds, or the reason why it cannot be used."""

    package: str  # name and version: "toy-engine 1.0"
    found: Any = None  # the object; None if it cannot be used
    reason: str = ""  # reason why the object cannot be used, one line

    @property
    def distribution(self) -> str:
        """Name of the installed package."""
        return self.package.partition(" ")[0]


@cache
def points(group: str) -> Mapping[str, tuple[metadata.EntryPoint, ...]]:
    """Returns the entry points of a group by name, none of them loaded. Several packages may have
    an entry point of one name."""
    # An entry point is listed twice if its folder is on the path twice.
    every = dict.fromkeys(metadata.entry_points(group=group))
    names = dict.fromkeys(point.name for point in every)
    return MappingProxyType({n: tuple(p for p in every if p.name == n) for n in names})


def versions() -> Mapping[str, str]:
    """Returns {package: version} for the packages that add engines or systems."""
    several = (points(group).values() for group in (ENGINES, SYSTEMS))
    added = (p.dist for entries in several for group in entries for p in group if p.dist)
    return {package.name: package.version for package in added}


@cache
def additions(group: str, wrong: Wrong) -> Mapping[str, Addition]:
    """Returns the objects that packages add to a group, by name, loaded once a process. If an
    object cannot be used, or prints while it is loaded, a line on stderr says so."""
    return {name: _addition(name, several, wrong) for name, several in points(group).items()}


def broken(group: str, wrong: Wrong, name: str) -> str:
    """Returns the requirement on a name whose package cannot be used, for a message; otherwise
    empty."""
    added = additions(group, wrong).get(name)
    reason = added and added.reason and f"one that can be used; {added.package}: {added.reason}"
    return reason or ""


def _addition(name: str, several: tuple[metadata.EntryPoint, ...], wrong: Wrong) -> Addition:
    """Loads and validates the object with this name. `several` are the entry points of the name,
    one a package; more than one is an error."""
    packages = [f"{p.dist.name} {p.dist.version}" if p.dist else p.module for p in several]
    loaded = None
    reason = ""
    printed = [""]
    if len(several) > 1:
        reason = f"more than one package adds {name!r}: {', '.join(packages)}"
    else:
        with captured() as printed:
            try:
                with border():
                    loaded = several[0].load()
            except Refused as error:
                kind, _, message = str(error).partition(": ")
                reason = f"{kind} on import: {message}"
        reason = shortened(reason or wrong(loaded, name))
    if reason:
        print(f"plumbob: {packages[0]} is left out: {reason}", file=sys.stderr)
        return Addition(packages[0], None, reason)
    if output := shortened(printed[0]):
        print(f"plumbob: {packages[0]} prints when it is imported: {output}", file=sys.stderr)
    return Addition(packages[0], loaded)


@contextmanager
def captured() -> Iterator[list[str]]:
    """Captures the output to stdout and stderr, of Python and of libraries in C. Afterwards the
    list holds the output as one text."""
    import tempfile

    output: list[str] = []
    text = io.StringIO()
    sys.stdout.flush()
    sys.stderr.flush()
    with tempfile.TemporaryFile() as file:
        kept = [(number, os.dup(number)) for number in (1, 2) if _open(number)]
        try:
            for number, _ in kept:
                os.dup2(file.fileno(), number)
            with redirect_stdout(text), redirect_stderr(text):
                yield output
        finally:
            for number, copy in kept:
                os.dup2(copy, number)
                os.close(copy)
            file.seek(0)
            output.append(text.getvalue() + file.read().decode("utf-8", "replace"))


@contextmanager
def on_stderr() -> Iterator[None]:
    """Redirects to stderr what the block prints on stdout, in Python or in C. A user's own code may
    print, and stdout is for results."""
    sys.stdout.flush()
    kept = os.dup(1) if _open(1) and _open(2) else None
    try:
        if kept is not None:
            os.dup2(2, 1)
        with redirect_stdout(sys.stderr):
            yield
    finally:
        if kept is not None:
            os.dup2(kept, 1)
            os.close(kept)


def _open(number: int) -> bool:
    """Whether a file descriptor is open."""
    try:
        os.fstat(number)
    except OSError:
        return False
    return True
