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

from plumbob.analytic.stability import Kind
from plumbob.engines.method import (
    Engine,
    KnownGradientLimit,
    KnownLimit,
    KnownStepLimit,
    NotRead,
    fits,
)

FOLDER = Path(__file__).parent / "limits"
SIZES = ".sizes.jsonl"  # suffix of the table of sizes beside a file of limits
Pair = tuple[str, str]  # the names of a scene and of a method
Entry = TypeVar("Entry", KnownLimit, KnownStepLimit, KnownGradientLimit, NotRead)


@dataclass(frozen=True)
class Size:
    """Relative errors that a method had on a scene, and the steps [s] that they are of."""

    size: float  # median over the finest runs
    coarse: float  # the coarsest step of those,
    fine: float  # and the finest
    low: float  # the smallest error of any run,
    high: float  # and the largest
    coarsest: float  # step of any run


@dataclass(frozen=True)
class Limits:
    """The declared limits of an engine, and how large their errors were."""

    known_limits: tuple[KnownLimit, ...] = ()  # the first that is of a pair counts
    step_limits: tuple[KnownStepLimit, ...] = ()
    gradient_limits: tuple[KnownGradientLimit, ...] = ()
    not_read: tuple[NotRead, ...] = ()
    sizes: Mapping[Pair, Size] = field(default_factory=dict)
    solvers: Mapping[Pair, Mapping[float, float]] = field(default_factory=dict)
    """Relative errors of solvers that choose their steps: at each tolerance at which it is above
    the round-off level."""
    measured_with: Mapping[str, str] = field(default_factory=dict)  # versions, by distribution
    loosely_known: Sequence[str] = ()
    """Patterns of methods whose errors differ between machines: known within a factor of two."""

    def limit(self, scene: str, method: str) -> KnownLimit | None:
        """The limit that a scene with a method has, or None."""
        return next(_of(self.known_limits, scene, method), None)

    def step_limit(self, scene: str, method: str, kind: Kind) -> KnownStepLimit | None:
        """The known limit of the largest step of a scene with a method, or None."""
        return next((k for k in _of(self.step_limits, scene, method) if k.kind == kind), None)

    def gradient(self, pair: Pair, by: str, way: str) -> KnownGradientLimit | None:
        """The known limit of a way's derivative by a parameter, or None."""
        held = _of(self.gradient_limits, *pair)
        return next((k for k in held if fits(by, k.by) and fits(way, k.ways)), None)

    def unread(self, scene: str, method: str) -> Mapping[str, str]:
        """{observable: why}: what the engine does not give of a scene with a method; the first
        reason counts."""
        reasons: dict[str, str] = {}
        for entry in _of(self.not_read, scene, method):
            reasons = dict.fromkeys(entry.observables, entry.reason) | reasons
        return reasons


def _of(entries: Iterable[Entry], scene: str, method: str) -> Iterator[Entry]:
    """The entries of a scene with a method."""
    return (k for k in entries if fits(method, k.methods) and fits(scene, k.scenes))


def declared_by(engine: Engine) -> Limits:
    """The limits that an engine has in a file, and that its package declares beside; raises what
    reading a file of another package raises."""
    stored = read(engine.limits) if engine.limits else _ours(engine.name)
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
    file = FOLDER / f"{name}.toml"
    return read(file) if file.is_file() else Limits()


@cache
def read(file: Path) -> Limits:
    """The limits in a TOML file, with the sizes in the table beside it if there is one. Raises
    OSError if the file cannot be read, and ValueError, TypeError or KeyError if it is no file of
    limits."""
    content = tomllib.loads(file.read_text("utf-8"))
    known_limits = _entries(KnownLimit, content.pop("known_limits", ()))
    step_limits = _entries(KnownStepLimit, content.pop("step_limits", ()))
    gradient_limits = _entries(KnownGradientLimit, content.pop("gradient_limits", ()))
    not_read = _entries(NotRead, content.pop("not_read", ()))
    declared = Limits(
        known_limits=known_limits,
        step_limits=step_limits,
        gradient_limits=gradient_limits,
        not_read=not_read,
        **content,  # `loosely_known`: another name is a TypeError
    )
    table = file.with_suffix(SIZES)
    return with_sizes(declared, table.read_text("utf-8")) if table.is_file() else declared


def with_sizes(declared: Limits, table: str) -> Limits:
    """The declared limits with the sizes of a table: its first line holds the versions that all
    sizes were measured with, each other line the sizes of a scene with a method, as JSON."""
    sizes: dict[Pair, Size] = {}
    solvers: dict[Pair, Mapping[float, float]] = {}
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
    """An entry of a kind for each table, whose lists of patterns are tuples."""
    return tuple(
        kind(**{key: tuple(v) if isinstance(v, list) else v for key, v in table.items()})
        for table in tables
    )
