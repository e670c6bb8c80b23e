"""Schemes stepped on the driven rotor in plain numbers, for steps that no series reaches.

A plain scheme's state is theta and theta_dot. Where a joint, solved for velocities, holds the bob,
it is theta, its rate w, and in the complex plane turning with the rod (1 outwards, i along theta)
the bob's velocity V and the joint's opening Z, both in units of the bob's distance d from the
joint. A bob of moment of inertia I = j m L^2, L its length as a pendulum, has d = s L with
s (1 - s) = j. The joint closes the part k of Z in a step h; F is the damping and forcing at the
step's start, U the velocity before the joint acts:

    D = h w,     theta' = theta + D,     Z' = e^(-iD) ((1 - k) Z + 1 + iD) - 1,
    U = e^(-iD) (V + i h F / s) + h (g / (s L)) (cos theta' - i sin theta'),
    w' = w + s (Im U - w + k Im Z' / h),                 V' = i w' - k Z' / h,
    T/(m L) = s Re(U + k Z' / h) / h.

The joint's impulse h T is added up in doubles: its rounding turns the bob by 1/I, but moves it by
1/m alone, and so does not last.

Numbers step from sample to sample. Arrays then step from all samples at once, with derivatives as
imaginary parts of 1e-30 of their size (Squire and Trapp 1998, SIAM Review 40, 110): by the state,
and by each coefficient.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbob.analytic.errors.smooth_motion.rotor_steps import Equation, advance, in_numbers
from plumbob.analytic.numerics.arithmetic import ROUNDOFF, ULP
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.reference import Array, Reference
from plumbob.analytic.schemes import STEPPED, Scheme
from plumbob.analytic.theory import SteppedErrors

MOST_STEPS = 2_000_000  # of a run: a few seconds
FORCE_ROUNDINGS = 8.0  # of a force, whose parts an engine adds up along its own way
FORCES = (0, 1, 2, 4, 7)  # the rotor's coefficients that are accelerations at 1 rad
OFF = 1e-6  # of a step: samples this far from a whole number of steps are not on the orbit
TINY = 1e-30  # imaginary part per derivative: its square is lost in a double
BLOCKS = 500  # parts of the orbit that arrays step at once
Marks = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Rod:
    """A rod's length [m], the gravity [m/s^2] and the bob's mass [kg] that together make its
    tension."""

    length: float
    gravity: float
    mass: float


def steps_until(times: Array, step: float, most: int = MOST_STEPS) -> Marks | None:
    """The numbers of steps of `step` [s] until `times` [s], shape (n,); None for more than `most`,
    and for times that are no multiples of the step."""
    marks = np.rint(times / step).astype(np.int64)
    if not 0 < int(marks[-1]) <= most:
        return None
    off = np.abs(times / step - marks).max()
    return marks if off <= OFF + ULP * marks[-1] else None


def stepped_errors(
    rotor: DrivenRotor,
    start: tuple[float, float],
    scheme: Scheme,
    step: float,
    times: Array,
    exact: Reference,
    rod: Rod | None = None,
) -> SteppedErrors:
    """Error of `scheme` with `step` [s] from `start`, theta [rad] and theta_dot [rad/s], at `times`
    [s], shape (n,), beside the `exact` motion: of theta, theta_dot, and of the tension where there
    is a rod. Empty for other schemes, for more than MOST_STEPS steps, for times that
    are no multiples of the step, and for an orbit that diverges."""
    marks = steps_until(times, step) if scheme.integrator in STEPPED else None
    if marks is None:
        return SteppedErrors({})
    with np.errstate(over="ignore", invalid="ignore"):  # an orbit that diverges between samples
        orbit = _orbit(rotor, start, scheme, step, marks.tobytes(), rod)
    if orbit is None:
        return SteppedErrors({})
    truth = exact.observe(times)
    errors = {name: values - truth[name] for name, values in orbit[0].items()}
    return SteppedErrors(errors, orbit[1])


@lru_cache(maxsize=16)  # the same for all methods of one scheme
def _orbit(
    rotor: DrivenRotor,
    start: tuple[float, float],
    scheme: Scheme,
    step: float,
    marks: bytes,
    rod: Rod | None,
) -> tuple[Mapping[str, Array], Mapping[str, Array]] | None:
    """Observables after these numbers of steps, shape (n,) each, and their uncertainty: the
    response to a unit in the last place of every input. None where doubles do not hold them."""
    wanted = np.frombuffer(marks, dtype=np.int64)
    last = int(wanted[-1])
    every = np.union1d(wanted, np.arange(0, last, max(1, last // BLOCKS)))
    states = _followed(rotor, start, scheme, step, every)
    if states is None:
        return None
    response = _responses(rotor, start, scheme, step, every, states)
    kept = np.isin(every, wanted)
    states, response = states[:, kept], response[kept]
    values, slopes = _observed(states, rod)
    doubts = np.abs(np.einsum("onj,njk->onk", slopes, response)).sum(axis=2)
    doubts += ULP * (1.0 + np.abs(values))
    if wanted[0] == 0:  # no step has been taken: a joint's pull is not read
        values[:, :1] = _observed(states[:2, :1], rod)[0]
    if rod is not None:
        parts = rod.length * states[1] ** 2 + rod.gravity * np.abs(np.cos(states[0]))
        doubts[2] += 3 * rod.mass * ULP * parts
    names = ("theta", "theta_dot", "tension")
    if not np.isfinite(doubts).all():
        return None
    return dict(zip(names, values, strict=False)), dict(zip(names, doubts, strict=False))


def _observed(states: Array, rod: Rod | None) -> tuple[Array, Array]:
    """Observables of states (d, n), the last of a joint's the pull, shape (observables, n), and
    their derivatives by the state, shape (observables, n, d)."""
    x, v = states[:2]
    values, slopes = [x, v], np.zeros((3, len(x), len(states)))
    slopes[0, :, 0] = slopes[1, :, 1] = 1.0
    if rod is None:
        return np.array(values), slopes[:2]
    if len(states) > 2:
        values.append(rod.mass * rod.length * states[-1])
        slopes[2, :, -1] = rod.mass * rod.length
    else:
        values.append(rod.mass * (rod.length * v**2 + rod.gravity * np.cos(x)))
        slopes[2, :, 0] = -rod.mass * rod.gravity * np.sin(x)
        slopes[2, :, 1] = 2.0 * rod.mass * rod.length * v
    return np.array(values), slopes


def _followed(
    rotor: DrivenRotor, start: tuple[float, float], scheme: Scheme, step: float, marks: Marks
) -> Array | None:
    """States after the increasing numbers of steps `marks`, 0 the first, shape (d, n); None where
    they exceed the range of doubles."""
    take, state = _stepper(rotor, astuple(rotor), start, scheme, step, math)
    states = [state]
    try:
        for first, after in pairwise(marks.tolist()):
            for n in range(first, after):
                state = take(n * step, *state)
            states.append(state)
    except (ValueError, OverflowError, ZeroDivisionError):  # math.sin of infinity
        return None
    reached = np.array(states).T
    return reached if np.isfinite(reached).all() else None


def _responses(
    rotor: DrivenRotor,
    start: tuple[float, float],
    scheme: Scheme,
    step: float,
    marks: Marks,
    states: Array,
) -> Array:
    """Response of the states at the marks to a unit in the last place of each number of the start
    and of each coefficient that is not zero, shape (n, d, inputs): along the blocks between marks,
    all stepped at once, one after the other."""
    size, varied = len(states), _varied(rotor, len(states))
    count, lengths = varied.shape[1], np.diff(marks)
    take, _ = _stepper(rotor, list(varied), start, scheme, step, np)
    state = np.repeat(states[:, None, :-1].astype(complex), count, axis=1)
    state[range(size), range(size)] += 1j * TINY
    for n in range(int(lengths.max())):
        after = np.array(np.broadcast_arrays(*take((marks[:-1] + n) * step, *state)))
        state = np.where(lengths > n, after, state)
    slopes, response = np.moveaxis(state.imag / TINY, 2, 0), np.eye(size, count)
    response[range(size), range(size)] = _rounded(rotor, scheme, step, states)
    responses = [response]
    for across in slopes:
        response = across[:, :size] @ response
        response[:, size:] += across[:, size:]
        responses.append(response)
    return np.array(responses)


def _varied(rotor: DrivenRotor, size: int) -> npt.NDArray[np.complex128]:
    """The coefficients, each that is not zero varied by an ulp in a derivative of its own after
    those of a state: shape (coefficients, derivatives, 1)."""
    values = np.array(astuple(rotor))
    varied = np.flatnonzero(values)
    count = size + len(varied)
    given = np.repeat(values[:, None, None].astype(complex), count, axis=1)
    given[varied, np.arange(size, count), 0] += 1j * TINY * ULP * np.abs(values[varied])
    return given


def _rounded(rotor: DrivenRotor, scheme: Scheme, step: float, states: Array) -> Array:
    """Roundings of the largest of `states` and of a step, shape (d,)."""
    rounded = ROUNDOFF * np.abs(states).max(axis=1)
    rounded[0] += ULP * step * np.abs(states[1]).max()
    force = sum(abs(astuple(rotor)[i]) for i in FORCES)
    rounded[1] += FORCE_ROUNDINGS * ULP * step * force
    if len(states) > 2:  # an opening rounds as lengths do; what an impulse lacks turns the bob
        rounded[3:5] = ULP
        if scheme.jointed_moment:
            turned = ULP * step * np.abs(states[-1]).max() / scheme.jointed_moment
            rounded[:2] += step * turned, turned
    return np.asarray(rounded)


def many_steps(
    rotor: DrivenRotor, start: tuple[float, float], scheme: Scheme, steps: Array
) -> tuple[Any, Sequence[Any]]:
    """The step of a `scheme` of STEPPED for many sizes at once, `steps` [s] of shape (n,), on
    arrays of that shape, and the state it begins with: the numbers of `start` and, with a joint,
    the bob's velocity, the opening's two parts and the pull."""
    # All of one type: numpy converts a number or a real array anew in each operation.
    steps = steps.astype(complex)
    coefficients = [np.full_like(steps, coefficient) for coefficient in astuple(rotor)]
    return _stepper(rotor, coefficients, start, scheme, steps, np)


def _stepper(
    rotor: DrivenRotor,
    given: Sequence[Any],
    start: tuple[float, float],
    scheme: Scheme,
    step: Any,
    library: Any,
) -> tuple[Any, Sequence[Any]]:
    """The step, of a time and the numbers of a state, and the state it begins with; arguments as
    those of `in_numbers`."""
    equation = in_numbers(rotor, given, scheme, step, library)
    if scheme.joint_closing_rate is None:
        return advance(scheme, equation), start
    closing, (theta, theta_dot) = scheme.joint_closing_rate, start
    joint = _Joint(
        equation,
        given[2],
        step,
        0.0 if math.isinf(closing) else library.exp(-closing * step),
        (1.0 + math.sqrt(1.0 - 4.0 * scheme.jointed_moment)) / 2.0,
        library,
    )
    a = b = 0.0 * step
    if math.isinf(closing):  # as open as the step before would have left it
        before = step * (theta_dot - step * float(rotor.acceleration(0.0, theta, theta_dot)))
        a, b = joint.turned(before, 1.0, before)
        a = a - 1.0
    return joint, (theta, theta_dot, theta_dot - joint.rate * b, a, b, 0.0 * step)


@dataclass(frozen=True)
class _Joint:
    """The step of a bob that a joint holds (module docstring)."""

    equation: Equation
    weight: Any  # g/L [1/s^2]
    step: Any  # h [s]
    kept: Any  # 1 - k
    part: float  # s
    library: Any

    @cached_property
    def rate(self) -> Any:
        """k / h [1/s]."""
        return (1.0 - self.kept) / self.step

    def turned(self, angle: Any, out: Any, aside: Any) -> tuple[Any, Any]:
        """A vector in axes that turn by an angle."""
        c, s = self.library.cos(angle), self.library.sin(angle)
        return c * out + s * aside, c * aside - s * out

    def __call__(
        self, t: Any, x: Any, w: Any, v: Any, a: Any, b: Any, pull: Any
    ) -> tuple[Any, ...]:
        turn, rate, lever = self.step * w, self.rate, self.step / self.part
        push = self.equation.undamped(t, 0.0, 0.0) - self.equation.damping * w
        x = x + turn
        outwards, along = self.turned(turn, -rate * a, v + lever * push)
        outwards = outwards + lever * self.weight * self.library.cos(x)
        along = along - lever * self.weight * self.library.sin(x)
        a, b = self.turned(turn, 1.0 + self.kept * a, turn + self.kept * b)
        a = a - 1.0
        w = w + self.part * (along - w + rate * b)
        return x, w, w - rate * b, a, b, (outwards + rate * a) / lever
