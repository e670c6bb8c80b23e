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
SAME_VERSIONS_FACTOR = 1.02
# Calibrated factor for an error at a single tolerance: rounding moves the steps, and the error may
# change its sign. The largest measured factor is 36.
SINGLE_TOLERANCE_FACTOR = 100.0
FINEST_RUNS = 5  # finest runs of the quick profile whose median error is a size
_STEP_ROUNDING = 1e-5  # relative difference of equal steps: the file holds six digits


def size_mismatch(known: Size, errors: Mapping[float, float], factor: float = FACTOR) -> str:
    """Message if the relative errors of a convergence study differ from the known size by more than
    a factor; empty if they do not. `errors` are by step [s]."""
    in_range = [
        error for step, error in errors.items() if _in_range(step, known.coarse, known.fine)
    ]
    if not in_range:
        steps = f"{known.coarse:g} to {known.fine:g} s"
        return f"its size is known at steps from {steps}, and no run has such a step"
    return _error_mismatch(median(in_range), known.size, known.size, factor)


def run_size_mismatch(known: Size, step: float, error: float) -> str:
    """Returns a message if the relative error of one run at `step` [s] lies outside the range of
    the known errors, widened by FACTOR. The message is empty if the error lies within the range.
    It is also empty if the step lies outside the steps of the known errors."""
    if not _in_range(step, known.coarsest, known.fine):
        return ""
    return _error_mismatch(error, known.low, known.high)


def measured_size(errors: Mapping[float, float]) -> Size:
    """Returns the size of the errors of a study of the quick profile. `errors` are relative, by
    step [s]."""
    steps = sorted(errors)
    finest = steps[:FINEST_RUNS]
    return Size(
        size=median(errors[step] for step in finest),
        coarse=finest[-1],
        fine=finest[0],
        low=min(errors.values()),
        high=max(errors.values()),
        coarsest=steps[-1],
    )


def tolerance_sizes_mismatch(
    known: Mapping[float, float], errors: Mapping[float, float], factor: float = FACTOR
) -> str:
    """Message if relative errors at tolerances differ from the `known` errors by more than a
    factor; empty if they do not, or if none of these tolerances was run. The median ratio over the
    tolerances must lie within `factor`. Rounding moves the steps, so one error may be small by
    chance: a single ratio must lie within SINGLE_TOLERANCE_FACTOR, unless the versions are those of
    the measurement."""
    single_factor = factor if factor < FACTOR else SINGLE_TOLERANCE_FACTOR
    ratios: list[float] = []
    for tolerance, size in known.items():
        if tolerance not in errors:
            continue
        mismatch = _error_mismatch(errors[tolerance], size, size, single_factor)
        if mismatch:
            return f"at a tolerance of {tolerance:g} {mismatch}"
        ratios.append(errors[tolerance] / size)
    median_ratio = median(ratios) if ratios else 1.0
    if 1.0 / factor <= median_ratio <= factor:
        return ""
    return (
        f"the median ratio of its relative errors to the known ones is {median_ratio:.3g}, and "
        f"must lie within a factor of {factor:g}"
    )


def known_factor(method: Method, versions: Mapping[str, str] | None) -> float:
    """Returns the factor within which the sizes of a method are known, for errors that were
    measured with these `versions` of packages (None: the installed versions)."""
    limits = limits_of(method.name)
    if fits(method.name, tuple(limits.loosely_known)):
        return FACTOR
    packages = packages_of(engine_of(method))
    used = versions_of(method) if versions is None else versions
    same = all(used.get(name, "") == limits.measured_with.get(name) for name in packages)
    return SAME_VERSIONS_FACTOR if same else FACTOR


def median_mismatch(size: float, errors: Mapping[float, float]) -> str:
    """Message if the median relative error of the finest runs differs from `size` by more than
    FACTOR; empty if it does not. `errors` are by step [s]."""
    finite = {step: error for step, error in errors.items() if math.isfinite(error)}
    if not finite:
        return "no run was made to its end"
    return _error_mismatch(measured_size(finite).size, size, size)


def _in_range(step: float, coarse: float, fine: float) -> bool:
    """Whether a step lies between two steps, the rounding of the file's numbers allowed for."""
    return fine * (1.0 - _STEP_ROUNDING) <= step <= coarse * (1.0 + _STEP_ROUNDING)


def _error_mismatch(error: float, low: float, high: float, factor: float = FACTOR) -> str:
    """Message if an error lies outside `low` to `high`, widened by a factor; empty if it does
    not."""
    if low / factor <= error <= high * factor:
        return ""
    known = f"{low:.3g}" if low == high else f"{low:.2g} to {high:.2g}"
    within = f"a factor of {factor:g}"
    if factor == SAME_VERSIONS_FACTOR:
        within = "2 %, for these versions"
    return f"its relative error is {error:.3g}, and known to be {known}, within {within}"
