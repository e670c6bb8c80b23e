"""Known limits of engines, and observables that they do not give: a TOML file an engine, ours in
the folder `limits`, those of other packages where these say; README.md explains the format."""

from __future__ import annotations

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
    """The content of a file of limits; raises OSError, and ValueError, TypeError and other errors
    where it is none."""
    content = tomllib.loads(file.read_text("utf-8"))
    sizes = _by_pair(content.pop("sizes", {}))
    solvers = _by_pair(content.pop("solvers", {}))
    return Limits(
        known_limits=_entries(KnownLimit, content.pop("known_limits", ())),
        step_limits=_entries(KnownStepLimit, content.pop("step_limits", ())),
        gradient_limits=_entries(KnownGradientLimit, content.pop("gradient_limits", ())),
        not_read=_entries(NotRead, content.pop("not_read", ())),
        sizes={pair: Size(**values) for pair, values in sizes.items()},
        solvers={
            pair: {float(t): e for t, e in held.items()} for pair, held in solvers.items()
        },
        **content,  # the versions; another name is an error
    )


def _entries(
    kind: Callable[..., Entry], tables: Iterable[Mapping[str, Any]]
) -> tuple[Entry, ...]:
    """An entry of a kind for each table, whose lists of patterns are tuples."""
    return tuple(
        kind(**{key: tuple(v) if isinstance(v, list) else v for key, v in table.items()})
        for table in tables
    )


def _by_pair(scenes: Mapping[str, Mapping[str, Any]]) -> dict[Pair, Mapping[str, Any]]:
    return {(scene, m): values for scene, held in scenes.items() for m, values in held.items()}
