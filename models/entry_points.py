"""Additions of other installed packages by entry points: they are loaded when a name is asked for
that is none of ours, and a broken one costs a line on stderr, not the study."""

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

ENGINES, SYSTEMS = "plumbob.engines", "plumbob.systems"  # the groups

Wrong = Callable[[Any, str], str]  # object and its name -> why it is not valid


@dataclass(frozen=True)
class Addition:
    """An object that a package adds, or the reason why it cannot."""

    package: str  # with its version: "toy-engine 1.0"
    found: Any = None
    reason: str = ""  # why there is nothing, one line

    @property
    def distribution(self) -> str:
        """Name of the package that is installed."""
        return self.package.partition(" ")[0]


@cache
def points(group: str) -> Mapping[str, tuple[metadata.EntryPoint, ...]]:
    """The entry points of a group by name, none of them loaded; several packages may have one of
    the same name."""
    # a folder may be on the path twice
    every = dict.fromkeys(metadata.entry_points(group=group))
    names = dict.fromkeys(point.name for point in every)
    return MappingProxyType({n: tuple(p for p in every if p.name == n) for n in names})


def versions() -> Mapping[str, str]:
    """The versions of the packages that add engines or systems, by the packages' names."""
    several = (points(group).values() for group in (ENGINES, SYSTEMS))
    added = (p.dist for entries in several for group in entries for p in group if p.dist)
    return {package.name: package.version for package in added}


@cache
def additions(group: str, wrong: Wrong) -> Mapping[str, Addition]:
    """The objects that packages add to a group, by their names, loaded once a process; of one that
    cannot be used, or prints, stderr says so."""
    return {name: _addition(name, several, wrong) for name, several in points(group).items()}


def broken(group: str, wrong: Wrong, name: str) -> str:
    """The requirement on a name whose package cannot be used; else empty."""
    added = additions(group, wrong).get(name)
    reason = added and added.reason and f"one that can be used; {added.package}: {added.reason}"
    return reason or ""


def _addition(name: str, several: tuple[metadata.EntryPoint, ...], wrong: Wrong) -> Addition:
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
    """Take what is written to stdout and stderr, by Python or by a library in C; the list holds it
    as one text afterwards."""
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
    """Redirects to stderr what the block prints on stdout, in Python or in C: a user's own code may
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
    try:
        os.fstat(number)
    except OSError:
        return False
    return True
