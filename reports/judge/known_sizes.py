"""Comparison of errors with their known sizes: a limit that grows or shrinks is no longer the known
one. An engine's limits state the sizes, and the versions of the packages that they were measured
with. For those versions the sizes are known more closely."""

from __future__ import annotations

import math
from collections.abc import Mapping
from statistics import median

from plumbob.engines.known_limits import Size
from plumbob.engines.method import Method, fits
from plumbob.engines.registry import engine_of, limits_of
from plumbob.engines.study.provenance import packages_of, versions_of

FACTOR = 2.0  # chosen factor within which a size is known: medians scatter by less, see tests
# Chosen factor for the versions that a size was measured with: their runs repeat to the bit.
# Another processor's rounding moves no size by more, see the tests.
SAME = 1.02
# Calibrated factor for an error at a single tolerance: rounding moves the steps, and the error may
# change its sign. The largest measured factor is 36.
SCATTER = 100.0
FINEST = 5  # finest runs of the quick profile whose median error is a size
_SAME = 1e-5  # relative difference of equal steps: the file holds six digits


def differs(known: Size, errors: Mapping[float, float], factor: float = FACTOR) -> str:
    """Message if the relative errors of a convergence study differ from the known size by more than
    a factor; empty if they do not. `errors` are by step [s]."""
    held = [e for step, e in errors.items() if _within(step, known.coarse, known.fine)]
    if not held:
        return f"no run at steps from {known.coarse:g} to {known.fine:g} s, where it is known"
    return _apart(median(held), known.size, known.size, factor)


def differs_at(known: Size, step: float, error: float) -> str:
    """Message if the relative error of one run at `step` [s] lies outside the range of the known
    errors, widened by FACTOR; empty if it does not, or at a step outside the known range of
    steps."""
    if not _within(step, known.coarsest, known.fine):
        return ""
    return _apart(error, known.low, known.high)


def measured(errors: Mapping[float, float]) -> Size:
    """Returns the size of the errors of a study of the quick profile. `errors` are relative, by
    step [s]."""
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
    """Message if relative errors at tolerances differ from the `known` errors by more than a
    factor; empty if they do not, or if none of these tolerances was run. The median ratio over the
    tolerances must lie within `factor`. Rounding moves the steps, so one error may be small by
    chance: a single ratio must lie within SCATTER, unless the versions are those of the
    measurement."""
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
    """Returns the factor within which the sizes of a method are known, for errors that were
    measured with these `versions` of packages (None: the installed versions)."""
    packages = packages_of(engine_of(method))
    now = versions_of(method) if versions is None else versions
    limits = limits_of(method.name)
    if fits(method.name, tuple(limits.loosely_known)):
        return FACTOR
    same = all(now.get(p, "") == limits.measured_with.get(p) for p in packages)
    return SAME if same else FACTOR


def differs_from(size: float, errors: Mapping[float, float]) -> str:
    """Message if the median relative error of the finest runs differs from `size` by more than
    FACTOR; empty if it does not. `errors` are by step [s]."""
    if not (finite := {step: e for step, e in errors.items() if math.isfinite(e)}):
        return "no run was made to its end"
    return _apart(measured(finite).size, size, size)


def _within(step: float, coarse: float, fine: float) -> bool:
    """Whether a step lies between two steps, the rounding of the file's numbers allowed for."""
    return fine * (1.0 - _SAME) <= step <= coarse * (1.0 + _SAME)


def _apart(error: float, low: float, high: float, factor: float = FACTOR) -> str:
    """Message if an error lies outside `low` to `high`, widened by a factor; empty if it does
    not."""
    if low / factor <= error <= high * factor:
        return ""
    known = f"{low:.3g}" if low == high else f"{low:.2g} to {high:.2g}"
    within = "2 %, for these versions" if factor == SAME else f"a factor of {factor:g}"
    return f"its relative error is {error:.3g}, and known to be {known}, within {within}"
