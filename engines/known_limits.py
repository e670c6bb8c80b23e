"""Known limits of engines, and observables that engines do not give. Each engine has a TOML file,
written by hand, and beside it a table of measured sizes, written by a command. The files of
plumbob's engines are in the folder `limits`; README.md explains both formats."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from plumbob.engines.method import (
    Engine,
    KnownGradientLimit,
    KnownLimit,
    KnownStepLimit,
    NotRead,
    NotRepeatable,
    fits,
)

FOLDER = Path(__file__).parent / "limits"
SIZES_SUFFIX = ".sizes.jsonl"  # suffix of the table of sizes beside a file of limits
SceneMethod = tuple[str, str]  # names of a scene and a method
Entry = TypeVar("Entry", KnownLimit, KnownStepLimit, KnownGradientLimit, NotRead, NotRepeatable)


@dataclass(frozen=True)
class Size:
    """Relative errors of a method on a scene, and the steps [s] of the runs that had them."""

    size: float  # median error of the finest runs
    coarse: float  # [s] largest step of the finest runs
    fine: float  # [s] smallest step of the finest runs
    low: float  # smallest error of all runs
    high: float  # largest error of all runs
    coarsest: float  # [s] largest step of all runs


@dataclass(frozen=True)
class Limits:
    """The declared limits of an engine, and the sizes of their errors when last measured."""

    known_limits: tuple[KnownLimit, ...] = ()  # the first that matches a pair counts
    step_limits: tuple[KnownStepLimit, ...] = ()
    gradient_limits: tuple[KnownGradientLimit, ...] = ()
    not_read: tuple[NotRead, ...] = ()
    not_repeatable: tuple[NotRepeatable, ...] = ()
    sizes: Mapping[SceneMethod, Size] = field(default_factory=dict)
    solvers: Mapping[SceneMethod, Mapping[float, float]] = field(default_factory=dict)
    """Relative errors of solvers that choose their steps, by tolerance, if above round-off."""
    measured_with: Mapping[str, str] = field(default_factory=dict)  # versions by distribution
    loosely_known: Sequence[str] = ()
    """Patterns of methods whose errors differ between machines, by up to a factor of two."""

    def limit(self, scene: str, method: str) -> KnownLimit | None:
        """The known limit of a scene with a method, or None."""
        return next(_matching(self.known_limits, scene, method), None)

    def step_limit(self, scene: str, method: str, kind: str) -> KnownStepLimit | None:
        """The known limit of the largest step of this kind of a scene with a method, or None."""
        matching = _matching(self.step_limits, scene, method)
        return next((limit for limit in matching if limit.kind == kind), None)

    def gradient(self, pair: SceneMethod, by: str, way: str) -> KnownGradientLimit | None:
        """The known limit of the derivative by a parameter that a way computes, or None."""
        for limit in _matching(self.gradient_limits, *pair):
            if fits(by, limit.by) and fits(way, limit.ways):
                return limit
        return None

    def other_bits(self, scene: str, method: str) -> str:
        """The reason why a scene with a method may not repeat its bits; empty if it should."""
        entry = next(_matching(self.not_repeatable, scene, method), None)
        return entry.reason if entry else ""

    def unread(self, scene: str, method: str) -> Mapping[str, str]:
        """{observable: reason} of the observables that the engine does not give for a scene with a
        method. The first declared reason counts."""
        reasons: dict[str, str] = {}
        for entry in _matching(self.not_read, scene, method):
            reasons = dict.fromkeys(entry.observables, entry.reason) | reasons
        return reasons


def _matching(entries: Iterable[Entry], scene: str, method: str) -> Iterator[Entry]:
    """The entries whose patterns match a scene and a method."""
    for entry in entries:
        if fits(method, entry.methods) and fits(scene, entry.scenes):
            yield entry


def declared_by(engine: Engine) -> Limits:
    """The limits of an engine: those in its file, and those that its package declares in Python.
    Raises any exception that reading a file of another package raises."""
    stored = read_limits(engine.limits) if engine.limits else _ours(engine.name)
    if not engine.known_limits and not engine.not_read:
        return stored
    never = tuple(NotRead("*", "*", (name,), why) for name, why in engine.not_read.items())
    return replace(
        stored,
        known_limits=(*engine.known_limits, *stored.known_limits),
        not_read=(*never, *stored.not_read),
    )


@cache
def _ours(name: str) -> Limits:
    """The limits of one of plumbob's engines, by its name."""
    file = FOLDER / f"{name}.toml"
    return read_limits(file) if file.is_file() else Limits()


@cache
def read_limits(file: Path) -> Limits:
    """The limits in a TOML file, with the sizes in the table beside it if there is one. Raises
    OSError if the file cannot be read, and ValueError, TypeError or KeyError if it is no file of
    limits."""
    content = tomllib.loads(file.read_text("utf-8"))
    known_limits = _entries(KnownLimit, content.pop("known_limits", ()))
    step_limits = _entries(KnownStepLimit, content.pop("step_limits", ()))
    gradient_limits = _entries(KnownGradientLimit, content.pop("gradient_limits", ()))
    not_read = _entries(NotRead, content.pop("not_read", ()))
    not_repeatable = _entries(NotRepeatable, content.pop("not_repeatable", ()))
    loosely_known = content.pop("loosely_known", ())
    if content:
        raise TypeError(f"unknown entries: {', '.join(content)}")
    declared = Limits(
        known_limits=known_limits,
        step_limits=step_limits,
        gradient_limits=gradient_limits,
        not_read=not_read,
        not_repeatable=not_repeatable,
        loosely_known=loosely_known,
    )
    table = file.with_suffix(SIZES_SUFFIX)
    return with_sizes(declared, table.read_text("utf-8")) if table.is_file() else declared


def with_sizes(declared: Limits, table: str) -> Limits:
    """The declared limits with the sizes of a table: its first line holds the versions that all
    sizes were measured with, each other line the sizes of a scene with a method, as JSON."""
    sizes: dict[SceneMethod, Size] = {}
    solvers: dict[SceneMethod, Mapping[float, float]] = {}
    first, *lines = table.splitlines()
    for line in lines:
        values = json.loads(line)
        pair = values.pop("scene"), values.pop("method")
        if "solver" in values:
            solvers[pair] = {float(t): error for t, error in values["solver"].items()}
        else:
            sizes[pair] = Size(**values)
    versions = json.loads(first)["measured_with"]
    return replace(declared, sizes=sizes, solvers=solvers, measured_with=versions)


def _entries(
    kind: Callable[..., Entry], tables: Iterable[Mapping[str, Any]]
) -> tuple[Entry, ...]:
    """An entry of this kind for each table of a file; lists of patterns become tuples."""
    entries = []
    for table in tables:
        fields = {
            name: tuple(value) if isinstance(value, list) else value
            for name, value in table.items()
        }
        entries.append(kind(**fields))
    return tuple(entries)
