"""The orbit of a one-step map, and a bound on the effect of rounding.

The map is written once, for plain numbers and for arrays. Numbers step it from sample to
sample. Arrays then step it from all samples at once, with derivatives as imaginary parts of 1e-30
of their size (Squire and Trapp 1998, SIAM Review 40, 110): M = dz'/dz of each step, and the
response to a unit in the last place of each coefficient and each number of the start. With M a
step's rounding, of standard deviation q, is carried on by the orbit itself:
C' = M C M^T + diag(q^2).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbob.analytic.numerics.arithmetic import ROUNDOFF, ULP
from plumbob.analytic.reference import Array

TINY = 1e-30  # imaginary part per derivative: its square is lost in a double
BLOCKS = 500  # parts of the orbit that arrays step at once
Marks = npt.NDArray[np.int64]
Complex = npt.NDArray[np.complex128]
State = tuple[Any, ...]
Function = Callable[..., Any]


@dataclass(frozen=True)
class Step:
    """A one-step map z' = advance(t, *z) and the observables of its states."""

    advance: Callable[..., State]
    observe: Callable[..., tuple[Any, ...]]


@dataclass(frozen=True)
class StepMap:
    """How a map is built of coefficients and of the functions sin and cos, and where it starts."""

    build: Callable[[tuple[Any, ...], Function, Function], Step]
    coefficients: tuple[float, ...]
    start: tuple[float, ...]
    noise: Callable[[Array], Array]
    """Size of what rounds in a step, in units of each state's own number: of states (d, n), the
    same shape; a standard deviation is ROUNDOFF times it."""


@dataclass(frozen=True)
class Orbit:
    """Observables at the marks, shape (n, observables), and their uncertainty: the response to a
    unit in the last place of every input, and 2/sqrt(steps) standard deviations of all roundings,
    so that 2 sqrt(steps) times it holds four of them."""

    values: Array
    uncertainty: Array


def orbit(step_map: StepMap, step: float, marks: Marks) -> Orbit | None:
    """The orbit of steps of `step` [s] after the increasing numbers of steps `marks`, shape (n,), 0
    the first; None where it exceeds the range of doubles."""
    last = int(marks[-1])
    every = np.union1d(marks, np.arange(0, last, max(1, last // BLOCKS)))
    built = step_map.build(step_map.coefficients, math.sin, math.cos)
    advance, state, states = built.advance, step_map.start, [step_map.start]
    try:
        for first, after in pairwise(every.tolist()):
            for n in range(first, after):
                state = advance(n * step, *state)
            states.append(state)
    except (ValueError, OverflowError, ZeroDivisionError):  # math.sin of infinity
        return None
    reached = np.array(states).T
    if not np.isfinite(reached).all():
        return None
    with np.errstate(over="ignore", invalid="ignore"):  # an orbit that diverges between samples
        return _with_uncertainty(step_map, step, every, reached, np.isin(every, marks))


def _with_uncertainty(
    step_map: StepMap, step: float, marks: Marks, reached: Array, kept: npt.NDArray[np.bool_]
) -> Orbit | None:
    """Carry the responses of the blocks between `marks` one after the other."""
    responses, covariances = _carried(*_blocks(step_map, step, marks, reached))
    size = len(step_map.start)
    states = reached[:, None, kept] + 1j * TINY * np.eye(size)[:, :, None]
    built = step_map.build(step_map.coefficients, _sine, _cosine)
    observed = np.array(np.broadcast_arrays(*built.observe(*states)))  # (observables, size, n)
    slopes = np.moveaxis(observed.imag / TINY, -1, 0)
    inputs = np.abs(slopes @ responses[kept]).sum(axis=2)
    spread = np.einsum("nij,njk,nik->ni", slopes, covariances[kept], slopes)
    values = observed[:, 0].real.T
    walk = 2.0 * np.sqrt(np.maximum(spread, 0.0) / max(1, int(marks[-1])))
    uncertainty = inputs + walk + ULP * np.abs(values)
    return Orbit(values, uncertainty) if np.isfinite(uncertainty).all() else None


def _blocks(
    step_map: StepMap, step: float, marks: Marks, reached: Array
) -> tuple[Array, Array, Array]:
    """Effect of the start, and then of each block between marks, on the state, shape (1 + blocks,
    ...): the derivative of its end by the state before it, (d, d), zero for the start; the response
    to an ulp of each coefficient that is not zero and of each number of the start, (d, c + d); the
    covariance of the roundings in it, (d, d)."""
    size, blocks, lengths = reached.shape[0], len(marks) - 1, np.diff(marks)
    inputs = _varied(step_map.coefficients, size)
    advance = step_map.build(tuple(inputs), _sine, _cosine).advance
    states: Array = reached[:, :-1].copy()
    flow = np.broadcast_to(np.eye(size), (blocks, size, size)).copy()
    forced = np.zeros((blocks, size, inputs.shape[1] - size))
    rounded = np.zeros((blocks, size, size))
    for n in range(int(lengths.max())):
        on = lengths > n
        new, slopes = _linearised(advance, (marks[:-1] + n) * step, states, forced)
        matrix = slopes[:, :, :size]
        carried = _rounded(matrix, rounded, step_map.noise(new))
        if on.all():
            states, flow, forced, rounded = new, matrix @ flow, slopes[:, :, size:], carried
            continue
        states = np.where(on, new, states)
        flow[on] = (matrix @ flow)[on]
        forced[on] = slopes[on][:, :, size:]
        rounded[on] = carried[on]
    return _from_the_start(step_map, reached[:, :1], flow, forced, rounded)


def _varied(coefficients: tuple[float, ...], size: int) -> Complex:
    """The coefficients, each that is not zero varied by an ulp in a derivative of its own after
    those of the state: shape (coefficients, derivatives, 1)."""
    varied = [i for i, value in enumerate(coefficients) if value]
    inputs = np.zeros((len(coefficients), size + len(varied), 1), dtype=complex)
    inputs.real = np.array(coefficients)[:, None, None]
    for column, i in enumerate(varied, start=size):
        inputs[i, column] += 1j * TINY * ULP * abs(coefficients[i])
    return inputs


def _linearised(
    advance: Callable[..., State], times: Any, states: Array, forced: Array
) -> tuple[Array, Array]:
    """States after a step, shape (d, blocks), and its derivatives, shape (blocks, d, d + c)."""
    size, blocks = states.shape
    begun = np.empty((size, size + forced.shape[2], blocks), dtype=complex)
    begun.real = states[:, None, :]
    begun.imag[:, :size] = TINY * np.eye(size)[:, :, None]
    begun.imag[:, size:] = TINY * np.moveaxis(forced, 0, -1)
    after = np.array(np.broadcast_arrays(*advance(times, *begun)))
    # in this order in memory, as products of matrices need it
    slopes = np.ascontiguousarray(np.moveaxis(after.imag, -1, 0)) / TINY
    return after[:, 0].real.copy(), slopes


def _rounded(matrix: Array, covariance: Array, noise: Array) -> Array:
    """Covariance of the roundings after a step that rounds by `noise`, shape (d, blocks)."""
    carried = matrix @ covariance @ np.swapaxes(matrix, 1, 2)
    diagonal = np.arange(len(noise))
    carried[:, diagonal, diagonal] += (ROUNDOFF * noise).T ** 2
    return carried


def _from_the_start(
    step_map: StepMap, begun: Array, flow: Array, forced: Array, rounded: Array
) -> tuple[Array, Array, Array]:
    """The effect of the start, before that of the blocks."""
    blocks, size, count = forced.shape
    start_response = np.hstack([np.zeros((size, count)), ULP * np.diag(np.abs(step_map.start))])
    first = np.diag(ROUNDOFF * step_map.noise(begun)[:, 0]) ** 2
    forced = np.concatenate([forced, np.zeros((blocks, size, size))], axis=2)
    return (
        np.concatenate([np.zeros((1, size, size)), flow]),
        np.concatenate([start_response[None], forced]),
        np.concatenate([first[None], rounded]),
    )


def _carried(flow: Array, forced: Array, rounded: Array) -> tuple[Array, Array]:
    """The responses and covariances after each block of `_blocks`, which may overwrite them: the
    blocks of a group one after the other, all groups at once, then the groups."""
    count = len(flow)
    width = math.isqrt(count - 1) + 1  # blocks of a group
    for first in range(1, width):
        group = slice(first, None, width)
        across, before = flow[group], slice(first - 1, first - 1 + width * len(flow[group]), width)
        forced[group] += across @ forced[before]
        rounded[group] += across @ rounded[before] @ np.swapaxes(across, 1, 2)
        flow[group] = across @ flow[before]
    for first in range(width, count, width):
        across = flow[first : first + width]
        forced[first : first + width] += across @ forced[first - 1]
        rounded[first : first + width] += across @ rounded[first - 1] @ np.swapaxes(across, 1, 2)
    return forced, rounded


def _sine(x: Any) -> Any:
    """Sine of numbers with derivatives as imaginary parts, which along axis 0 have one real
    part."""
    angle = x.real[:1]
    return np.sin(angle) + 1j * (np.cos(angle) * x.imag)


def _cosine(x: Any) -> Any:
    """Cosine, as `_sine`."""
    angle = x.real[:1]
    return np.cos(angle) - 1j * (np.sin(angle) * x.imag)


def seen_by(names: tuple[str, ...], values: Array) -> Mapping[str, Array]:
    """Columns of `values`, shape (n, len(names)), by name."""
    return dict(zip(names, values.T, strict=True))
