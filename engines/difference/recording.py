"""A recorded motion: its samples, checked against a model, and how finely its numbers are given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.own_motion import OwnModel
from plumbob.engines.tangent_space import space_of_layout
from plumbob.models.border import must_be

PARTS = ("time", "qpos", "qvel", "act", "ctrl", "qacc_warmstart")  # arrays of a recording
BARE_COLUMNS = "columns"  # array with a column for each number, in the order of PARTS
UNIT_LENGTH = 1e-3  # largest error of the length of a recorded quaternion
# A double is within this many units in its last place of the decimal number that it was read from.
READ_BACK = 2.0
MOST_DIGITS = 14
TRIED_NUMBERS = 2000  # numbers of a recording that are tried for their digits


@dataclass(frozen=True)
class Resolution:
    """How finely the numbers of a recording are given: the larger of a fraction of each number and
    an absolute size."""

    words: str  # "double", "single", "6 significant digits", "6 decimals"
    relative: float
    absolute: float = 0.0

    def unit(self, values: Array) -> Array:
        """Returns the distance of each value to the next that the recording can give."""
        return np.maximum(self.relative * np.abs(values), self.absolute)


DOUBLE = Resolution("double", float(np.finfo("f8").eps))
SINGLE = Resolution("single", float(np.finfo("f4").eps))
PRECISIONS = MappingProxyType({"float64": DOUBLE, "float32": SINGLE})


@dataclass(frozen=True)
class Recording:
    """A recorded motion of a model."""

    name: str
    times: Array  # [s], shape (n,)
    states: Array  # qpos, qvel and act, shape (n, numbers)
    controls: Array  # the controls held from each sample on, shape (n, controls)
    # Acceleration with which the solver begins at each sample, shape (n, degrees of freedom); None
    # if it was not recorded
    warm_starts: Array | None
    resolution: Resolution


def recording_of(
    arrays: Mapping[str, Any],
    name: str,
    model: OwnModel,
    controls: Array | None = None,
    precision: str | None = None,
) -> Recording:
    """Returns the recording in `arrays` (PARTS by name), called `name` in messages, of a model.
    `controls` replace those of the arrays. A `precision` in PRECISIONS replaces the one that the
    numbers show. Raises ParameterError."""
    space = space_of_layout(model.layout)
    activations = model.state.size - space.positions - space.velocities
    sizes = {
        "qpos": space.positions,
        "qvel": space.velocities,
        "act": activations,
        "ctrl": len(model.layout.actuators),
        "qacc_warmstart": space.velocities,
    }
    arrays = _split_columns(arrays, name, sizes) if BARE_COLUMNS in arrays else dict(arrays)
    times = _numbers(arrays, name, "time").ravel()
    _check_times(times, name)
    if controls is not None:
        arrays["ctrl"] = controls
    parts = {
        part: _rows(arrays, name, part, len(times), size)
        for part, size in sizes.items()
        if size
    }
    if "qpos" not in parts or "qvel" not in parts:
        raise ParameterError(name, sorted(arrays), "a recording with qpos and qvel")
    states = np.hstack([parts[part] for part in ("qpos", "qvel", "act") if part in parts])
    for first, _ in space.attitudes:
        lengths = np.linalg.norm(states[:, first : first + 4], axis=1)
        if np.abs(lengths - 1.0).max() > UNIT_LENGTH:
            row = int(np.argmax(np.abs(lengths - 1.0)))
            wanted = f"such that qpos {first} to {first + 3} of row {row} is a unit quaternion"
            raise ParameterError(name, f"length {lengths[row]:g}", wanted)
    return Recording(
        name=name,
        times=times,
        states=states,
        controls=parts.get("ctrl", np.zeros((len(times), 0))),
        warm_starts=parts.get("qacc_warmstart") if "qacc_warmstart" in arrays else None,
        resolution=resolution_of(states) if precision is None else PRECISIONS[precision],
    )


def _split_columns(
    arrays: Mapping[str, Any], name: str, sizes: Mapping[str, int]
) -> dict[str, Any]:
    """Returns the parts of a recording from an array with a column for each number: time, qpos,
    qvel, act and ctrl, which may be left out. Raises ParameterError."""
    columns = np.asarray(arrays[BARE_COLUMNS])
    parts = {"time": 1} | {part: sizes[part] for part in ("qpos", "qvel", "act", "ctrl")}
    whole = sum(parts.values())
    if columns.shape[1] == whole - parts["ctrl"]:
        del parts["ctrl"]
    elif columns.shape[1] != whole:
        shown = f"{columns.shape[1]} columns"
        wanted = f"{whole} columns (time, qpos, qvel, act, ctrl), or named columns"
        raise ParameterError(name, shown, wanted)
    ends = np.cumsum(list(parts.values()))[:-1]
    return dict(zip(parts, np.split(columns, ends, axis=1), strict=True))


def _numbers(arrays: Mapping[str, Any], name: str, part: str) -> Array:
    """Returns a part of a recording as finite numbers. Raises ParameterError."""
    if part not in arrays:
        raise ParameterError(name, sorted(arrays), f"a recording with {part}")
    with must_be(f"rows of numbers in {part}", name, part):
        values = np.asarray(arrays[part])
        if values.dtype.kind not in "fiu":
            raise ValueError(f"numbers, not {values.dtype}")
        values = np.atleast_1d(values.astype(float))
    if not values.size:
        raise ParameterError(name, f"no numbers in {part}", "a recording with samples")
    finite = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
    if not finite.all():
        raise ParameterError(name, f"{part} of row {int(np.argmin(finite))}", "finite numbers")
    return values


def _check_times(times: Array, name: str) -> None:
    """Raises ParameterError if the times [s] of a recording do not rise."""
    if len(times) < 2:
        raise ParameterError(name, f"{len(times)} samples", "two samples or more")
    falls = np.flatnonzero(np.diff(times) <= 0.0)
    if falls.size:
        row = int(falls[0]) + 1
        shown = f"time {times[row]:g} s in row {row} after {times[row - 1]:g} s"
        raise ParameterError(name, shown, "times that rise")


def _rows(arrays: Mapping[str, Any], name: str, part: str, count: int, size: int) -> Array:
    """Returns a part of a recording with `count` rows of `size` numbers. A warm start may be left
    out, and the controls of the last sample. Raises ParameterError."""
    if part == "qacc_warmstart" and part not in arrays:
        return np.zeros((count, size))
    if part == "ctrl" and part not in arrays:
        raise ParameterError(
            name, "no ctrl", f"a recording with {size} controls, or --controls"
        )
    values = _numbers(arrays, name, part)
    values = values.reshape(len(values), -1)
    if part == "ctrl" and len(values) == count - 1:
        values = np.vstack([values, values[-1:]])
    if values.shape != (count, size):
        shown = f"{part} of shape {np.shape(arrays[part])}"
        raise ParameterError(
            name, shown, f"of shape ({count}, {size}), as times and model have"
        )
    return values


def resolution_of(states: Array) -> Resolution:
    """Returns how finely the numbers of recorded states, shape (n, numbers), are given."""
    values = states[np.any(states != states[0], axis=1)].ravel()
    values = values[values != 0.0]
    if not values.size:
        return DOUBLE
    chosen = values[:: max(1, len(values) // TRIED_NUMBERS)]
    with np.errstate(over="ignore"):  # infinite in single precision: not equal
        in_single = chosen.astype("f4").astype(float)
    if np.array_equal(in_single, chosen):
        return SINGLE
    read_back = READ_BACK * np.spacing(np.abs(chosen))
    exponents = np.floor(np.log10(np.abs(chosen)))
    for digits in range(3, MOST_DIGITS + 1):
        if _is_rounded(chosen, read_back, np.full_like(chosen, digits)):
            return Resolution(f"{digits} decimals", DOUBLE.relative, 10.0**-digits)
        if _is_rounded(chosen, read_back, digits - 1 - exponents):
            return Resolution(f"{digits} significant digits", 10.0 ** (1 - digits))
    return DOUBLE


def _is_rounded(values: Array, read_back: Array, decimals: Array) -> bool:
    """Returns whether each value has at most its number of `decimals`, as far as a double holds
    it."""
    with np.errstate(all="ignore"):  # not finite where the scale is out of range: not rounded
        scale = 10.0**decimals
        off = np.abs(np.rint(values * scale) / scale - values)
    return bool((off <= read_back).all())
