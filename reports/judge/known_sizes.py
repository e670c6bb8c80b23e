"""Whether an error has the size that is known of it: a limit that grows or shrinks is no longer the
known one. Sizes stand with the limits of an engine, and with the versions that they were measured
with, for which they are known more closely."""

from __future__ import annotations

import math
from collections.abc import Mapping
from statistics import median

from plumbob.engines.known_limits import Size
from plumbob.engines.method import Method, fits
from plumbob.engines.registry import engine_of, limits_of
from plumbob.engines.study.provenance import packages_of, versions_of

FACTOR = 2.0  # chosen: a size is known within it; medians scatter by less, see the tests
# Chosen, for the versions that a size was measured with, whose runs repeat themselves to the bit:
# what another processor rounds otherwise moves no size by more, see the tests.
SAME = 1.02
# Calibrated: of an error at one tolerance, where rounding moves steps and it changes its sign; 36
# was measured.
SCATTER = 100.0
FINEST = 5  # runs of the quick profile, of whose errors a size is the median
_SAME = 1e-5  # of a step, relative: the file holds six digits


def differs(known: Size, errors: Mapping[float, float], factor: float = FACTOR) -> str:
    """Why the relative errors of a convergence study, by step [s], are not those known, within a
    factor; empty where they are."""
    held = [e for step, e in errors.items() if _within(step, known.coarse, known.fine)]
    if not held:
        return f"no run at steps from {known.coarse:g} to {known.fine:g} s, where it is known"
    return _apart(median(held), known.size, known.size, factor)


def differs_at(known: Size, step: float, error: float) -> str:
    """Why the relative error of one run at `step` [s] is none of those known: it is to lie within
    the factor of what the study spans; of steps beyond it nothing is known."""
    if not _within(step, known.coarsest, known.fine):
        return ""
    return _apart(error, known.low, known.high)


def measured(errors: Mapping[float, float]) -> Size:
    """The size of the errors of a study of the quick profile, relative, by step [s]."""
    steps = sorted(errors)
    chosen = steps[:FINEST]
    return Size(
        median(errors[step] for step in chosen),
        chosen[-1],
        chosen[0],
        min(errors.values()),
        max(errors.values()),
        steps[-1],
    )


def not_those(
    known: Mapping[float, float], errors: Mapping[float, float], factor: float = FACTOR
) -> str:
    """Why relative errors at tolerances are not those `known`, within a factor; empty where they
    are, and where none of these tolerances was run. Where rounding moves the steps, the error at
    one tolerance may be small by chance, by SCATTER: it is their median that is known closer."""
    single = factor if factor < FACTOR else SCATTER
    ratios = {tol: errors[tol] / size for tol, size in known.items() if tol in errors}
    apart = ((tol, _apart(errors[tol], known[tol], known[tol], single)) for tol in ratios)
    if why := next((f"at a tolerance of {tol:g} {why}" for tol, why in apart if why), ""):
        return why
    middle = median(ratios.values()) if ratios else 1.0
    if 1.0 / factor <= middle <= factor:
        return ""
    return (
        f"its relative errors are {middle:.3g} of those known, in the median over tolerances, and "
        f"known within a factor of {factor:g}"
    )


def known_within(method: Method, versions: Mapping[str, str] | None) -> float:
    """The factor within which sizes of a method are known, for what was measured with these
    `versions` of packages (None: those that are installed)."""
    packages = packages_of(engine_of(method))
    now = versions_of(method) if versions is None else versions
    limits = limits_of(method.name)
    if fits(method.name, tuple(limits.loosely_known)):
        return FACTOR
    same = all(now.get(p, "") == limits.measured_with.get(p) for p in packages)
    return SAME if same else FACTOR


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
