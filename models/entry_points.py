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

ENGINE_GROUP, SYSTEMS = "plumbob.engines", "plumbob.systems"  # groups of entry points

# Returns the reason why an object with a name is not valid; empty if it is valid.
FindFault = Callable[[Any, str], str]


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
def entry_points_by_name(group: str) -> Mapping[str, tuple[metadata.EntryPoint, ...]]:
    """Returns the entry points of a group by name, none of them loaded. Several packages may have
    an entry point of one name."""
    by_name: dict[str, tuple[metadata.EntryPoint, ...]] = {}
    # An entry point is listed twice if its folder is on the path twice.
    for point in dict.fromkeys(metadata.entry_points(group=group)):
        by_name[point.name] = (*by_name.get(point.name, ()), point)
    return MappingProxyType(by_name)


def plugin_versions() -> Mapping[str, str]:
    """Returns {package: version} for the packages that add engines or systems."""
    packages: dict[str, str] = {}
    for group in (ENGINE_GROUP, SYSTEMS):
        for points in entry_points_by_name(group).values():
            for point in points:
                if point.dist:
                    packages[point.dist.name] = point.dist.version
    return packages


@cache
def additions(group: str, find_fault: FindFault) -> Mapping[str, Addition]:
    """Returns the objects that packages add to a group, by name, loaded once a process. If an
    object cannot be used, or prints while it is loaded, a line on stderr says so."""
    return {
        name: _load_addition(name, points, find_fault)
        for name, points in entry_points_by_name(group).items()
    }


def broken_requirement(group: str, find_fault: FindFault, name: str) -> str:
    """Returns the requirement on a name whose package cannot be used, for a message; otherwise
    empty."""
    addition = additions(group, find_fault).get(name)
    if addition is None or not addition.reason:
        return ""
    return f"one that can be used; {addition.package}: {addition.reason}"


def _load_addition(
    name: str, points: tuple[metadata.EntryPoint, ...], find_fault: FindFault
) -> Addition:
    """Loads and validates the object with this name. `points` are the entry points of the name, one
    a package; more than one is an error."""
    packages = []
    for point in points:
        dist = point.dist
        packages.append(f"{dist.name} {dist.version}" if dist else point.module)
    loaded = None
    output = ""
    if len(points) > 1:
        reason = f"more than one package adds {name!r}: {', '.join(packages)}"
    else:
        loaded, reason, output = _load(points[0])
        reason = reason or find_fault(loaded, name)
    package = packages[0]
    if reason:
        reason = shortened(reason)
        print(f"plumbob: {package} is left out: {reason}", file=sys.stderr)
        return Addition(package, None, reason)
    if output:
        print(f"plumbob: {package} prints when it is imported: {output}", file=sys.stderr)
    return Addition(package, loaded)


def _load(point: metadata.EntryPoint) -> tuple[Any, str, str]:
    """Returns the object of an entry point, or None and the reason why it cannot be loaded; and the
    output of loading it, in one line."""
    loaded = None
    reason = ""
    with captured() as printed:
        try:
            with border():
                loaded = point.load()
        except Refused as error:
            kind, _, message = str(error).partition(": ")
            reason = f"{kind} on import: {message}"
    return loaded, reason, shortened(printed[0])


@contextmanager
def captured() -> Iterator[list[str]]:
    """Captures the output to stdout and stderr, of Python and of libraries in C. Afterwards the
    list holds the output as one text."""
    import tempfile

    output: list[str] = []
    python_output = io.StringIO()
    sys.stdout.flush()
    sys.stderr.flush()
    with tempfile.TemporaryFile() as file:
        copies = {number: os.dup(number) for number in (1, 2) if _is_open(number)}
        try:
            for number in copies:
                os.dup2(file.fileno(), number)
            with redirect_stdout(python_output), redirect_stderr(python_output):
                yield output
        finally:
            for number, copy in copies.items():
                os.dup2(copy, number)
                os.close(copy)
            file.seek(0)
            c_output = file.read().decode("utf-8", "replace")
            output.append(python_output.getvalue() + c_output)


@contextmanager
def on_stderr() -> Iterator[None]:
    """Redirects to stderr what the block prints on stdout, in Python or in C. A user's own code may
    print, and stdout is for results."""
    sys.stdout.flush()
    stdout_copy = os.dup(1) if _is_open(1) and _is_open(2) else None
    try:
        if stdout_copy is not None:
            os.dup2(2, 1)
        with redirect_stdout(sys.stderr):
            yield
    finally:
        if stdout_copy is not None:
            os.dup2(stdout_copy, 1)
            os.close(stdout_copy)


def _is_open(number: int) -> bool:
    """Whether a file descriptor is open."""
    try:
        os.fstat(number)
    except OSError:
        return False
    return True
