"""How large the error of a known limit is: a limit that grows or shrinks is no longer the one that
is known. The sizes stand in known_limits.toml, with the versions that they were measured with, for
which they are known more closely; `python -m plumbob.tests.validation.limit_sizes` writes it."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache, lru_cache
from pathlib import Path
from statistics import median
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import KnownLimit, Method
from plumbob.engines.registry import engine_of, find_engine
from plumbob.engines.study.provenance import packages_of, versions_of

FILE = Path(__file__).with_suffix(".toml")
FACTOR = 2.0  # chosen: a size is known within it; medians scatter by less, see the tests
# Chosen, for the versions that a size was measured with, whose runs repeat themselves to the bit:
# what another processor rounds otherwise moves no size by more, see the tests.
SAME = 1.02
FINEST = 5  # runs of the quick profile, of whose errors a size is the median
_SAME = 1e-5  # of a step, relative: the file holds six digits


@dataclass(frozen=True)
class Size:
    """Relative errors that a method had on a scene, and the steps [s] that they are of."""

    size: float  # median over the finest runs
    coarse: float  # the coarsest step of those,
    fine: float  # and the finest
    low: float  # the smallest error of any run,
    high: float  # and the largest
    coarsest: float  # step of any run

    def differs(self, errors: Mapping[float, float], factor: float = FACTOR) -> str:
        """Why the relative errors of a convergence study, by step [s], are not those known, within
        a factor; empty where they are."""
        held = [e for step, e in errors.items() if _within(step, self.coarse, self.fine)]
        if not held:
            return f"no run at steps from {self.coarse:g} to {self.fine:g} s, where it is known"
        return _apart(median(held), self.size, self.size, factor)

    def differs_at(self, step: float, error: float) -> str:
        """Why the relative error of one run at `step` [s] is none of those known: it is to lie
        within the factor of what the study spans; of steps beyond it nothing is known."""
        if not _within(step, self.coarsest, self.fine):
            return ""
        return _apart(error, self.low, self.high)


def measured(errors: Mapping[float, float]) -> Size:
    """The size of the errors of a study of the quick profile, relative, by step [s]."""
    steps = sorted(errors)
    chosen = steps[:FINEST]
    return Size(
        median(errors[step] for step in chosen), chosen[-1], chosen[0],
        min(errors.values()), max(errors.values()), steps[-1],
    )  # fmt: skip


@cache
def sizes() -> Mapping[tuple[str, str], Size]:
    """The known sizes by scene and method."""
    return {
        (scene, method): Size(**values)
        for scene, methods in stored()["limits"].items()
        for method, values in methods.items()
    }


@cache
def errors_of_solvers() -> Mapping[tuple[str, str], Mapping[float, float]]:
    """The known relative errors of solvers that choose their steps, by scene and method: at each
    tolerance at which it is above the round-off level."""
    return {
        (scene, method): {float(tolerance): error for tolerance, error in held.items()}
        for scene, methods in stored()["solvers"].items()
        for method, held in methods.items()
    }


def not_those(
    known: Mapping[float, float], errors: Mapping[float, float], factor: float = FACTOR
) -> str:
    """Why relative errors at tolerances are not those `known`, within a factor; empty where they
    are, and where none of these tolerances was run."""
    both = ((tol, _apart(errors[tol], size, size, factor)) for tol, size in known.items()
            if tol in errors)  # fmt: skip
    return next((f"at a tolerance of {tol:g} {why}" for tol, why in both if why), "")


@cache
def stored() -> Mapping[str, Any]:
    """The content of the file: sizes, and the versions that they were measured with."""
    return tomllib.loads(FILE.read_text("utf-8"))


def known_within(method: Method, versions: Mapping[str, str] | None) -> float:
    """The factor within which sizes of a method are known, for what was measured with these
    `versions` of packages (None: those that are installed)."""
    packages = packages_of(engine_of(method))
    now = versions_of(method) if versions is None else versions
    held = stored()["measured_with"]
    return SAME if all(now.get(p, "") == held.get(p) for p in packages) else FACTOR


@lru_cache(maxsize=1 << 16)  # a page asks a million times
def fits(name: str, pattern: str) -> bool:
    """Whether the name of a scene or a method is of a shell pattern."""
    return fnmatchcase(name, pattern)


def declared_limit(scene: str, method: str) -> KnownLimit | None:
    """The limit that an added engine's package declares for a scene with a method of it, or
    None."""
    try:
        limits = find_engine(method.partition("/")[0]).known_limits
    except ParameterError:  # of a stored study, whose engine is no longer there
        return None
    return next((k for k in limits if k.method == method and fits(scene, k.scenes)), None)


def differs_from(size: float, errors: Mapping[float, float]) -> str:
    """Why the relative errors of a convergence study, by step [s], are not of this size, the
    median over the finest runs; empty where they are."""
    if not (finite := {step: e for step, e in errors.items() if math.isfinite(e)}):
        return "no run was made to its end"
    return _apart(measured(finite).size, size, size)


def _within(step: float, coarse: float, fine: float) -> bool:
    return fine * (1.0 - _SAME) <= step <= coarse * (1.0 + _SAME)


def _apart(error: float, low: float, high: float, factor: float = FACTOR) -> str:
    if low / factor <= error <= high * factor:
        return ""
    known = f"{low:.3g}" if low == high else f"{low:.2g} to {high:.2g}"
    within = "2 %, for these versions" if factor == SAME else f"a factor of {factor:g}"
    return f"its relative error is {error:.3g}, and known to be {known}, within {within}"
