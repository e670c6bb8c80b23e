"""The schemes' steps on the driven rotor in plain numbers, for steps that no series reaches.

Each step is written here again from its definition, independently of any engine. A plain scheme's
state is theta and theta_dot. Where a joint, solved for velocities, holds the bob, it is theta, its
rate w, and in the complex plane turning with the rod (1 outwards, i along theta) the bob's velocity
V and the joint's opening Z, both in units of the bob's distance d from the joint. A bob of moment
of inertia I = j m L^2, L its length as a pendulum, has d = s L with s (1 - s) = j. The joint closes
the part k of Z in a step h; F is the damping and forcing at the
step's start, U the velocity before the joint acts:

    D = h w,     theta' = theta + D,     Z' = e^(-iD) ((1 - k) Z + 1 + iD) - 1,
    U = e^(-iD) (V + i h F / s) + h (g / (s L)) (cos theta' - i sin theta'),
    w' = w + s (Im U - w + k Im Z' / h),                 V' = i w' - k Z' / h,
    T/(m L) = s Re(U + k Z' / h) / h.

The joint's impulse h T is added up in doubles: its rounding turns the bob by 1/I, but moves it by
1/m alone, and so does not last.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.errors.smooth_motion.stepped_orbit import (
    Function,
    Orbit,
    State,
    Step,
    StepMap,
    orbit,
    seen_by,
)
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.reference import Array, Reference
from plumbob.analytic.schemes import EULER, LEAPFROG, STEPPED, TABLEAUX, Scheme
from plumbob.analytic.tableau import Tableau, along
from plumbob.analytic.theory import SteppedErrors

MOST_STEPS = 2_000_000  # of a run: a few seconds
FORCE_ROUNDINGS = 8.0  # of a force, whose parts an engine adds up along its own way
OFF = 1e-6  # of a step: samples this far from a whole number of steps are not on the orbit
READ_AT = MappingProxyType(
    {"start": 0.0, "midpoint": 0.5}
)  # where in a step a held control is read


@dataclass(frozen=True)
class Rod:
    """A rod's length [m], the gravity [m/s^2] and the bob's mass [kg] that together make its
    tension."""

    length: float
    gravity: float
    mass: float


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
    nothing = SteppedErrors({}, None)
    marks = np.rint(times / step).astype(np.int64)
    if scheme.integrator not in STEPPED or not 0 < int(marks[-1]) <= MOST_STEPS:
        return nothing
    if np.abs(times / step - marks).max() > OFF + ULP * marks[-1]:
        return nothing
    stepped = _orbit(rotor, start, scheme, step, marks.tobytes(), rod)
    if stepped is None:
        return nothing
    names = ("theta", "theta_dot", "tension")[: stepped.values.shape[1]]
    observed, truth = seen_by(names, stepped.values), exact.observe(times)
    return SteppedErrors(
        {name: observed[name] - truth[name] for name in names}, seen_by(names, stepped.uncertainty)
    )


@lru_cache(maxsize=16)  # the same for all methods of one scheme
def _orbit(
    rotor: DrivenRotor,
    start: tuple[float, float],
    scheme: Scheme,
    step: float,
    marks: bytes,
    rod: Rod | None,
) -> Orbit | None:
    wanted = np.frombuffer(marks, dtype=np.int64)
    every = wanted if wanted[0] == 0 else np.append(0, wanted)
    chosen = _plain if scheme.joint_closing_rate is None else _jointed
    stepped = orbit(chosen(rotor, start, scheme, step, rod), step, every)
    if stepped is None:
        return None
    values, doubt = stepped.values[-len(wanted) :], stepped.uncertainty[-len(wanted) :] + ULP
    if rod is not None:
        theta, rate = values[:, 0], values[:, 1]
        parts = rod.length * rate**2 + rod.gravity * np.abs(np.cos(theta))
        doubt = doubt + np.outer(3 * rod.mass * ULP * parts, [0.0, 0.0, 1.0])
        if wanted[0] == 0:  # no step has been taken: a joint's pull is not read
            values = values.copy()
            values[0, 2] = rod.mass * (rod.length * rate[0] ** 2 + rod.gravity * math.cos(theta[0]))
    return Orbit(values, doubt)


@dataclass(frozen=True)
class _Torques:
    """The equation of motion without damping, in plain numbers or in arrays."""

    rotor: DrivenRotor  # which terms there are
    step: Any  # [s], a number or an array
    scheme: Scheme
    given: tuple[Any, ...]  # the rotor's coefficients, in its order
    sin: Function
    cos: Function

    def pull(self) -> Function:
        """Acceleration by theta."""
        sin2, along, down, _, _, _, _, stiffness = self.given
        rotor, sin, cos = self.rotor, self.sin, self.cos
        back, up, twice = -stiffness, -down, 2.0 * sin2
        if rotor.linear:
            return lambda x: back * x
        if not (rotor.sin2 or rotor.cos or rotor.stiffness):
            return lambda x: up * sin(x)

        def turning(x: Any) -> Any:
            sine = sin(x)
            return (twice * sine + along) * cos(x) - down * sine

        return (lambda x: turning(x) - stiffness * x) if rotor.stiffness else turning

    def push(self) -> Function:
        """Acceleration by the forcing in the step from t, at a fraction of it."""
        _, _, _, _, amplitude, frequency, phase, _ = self.given
        if self.rotor.autonomous:
            return lambda t, fraction: 0.0
        h, sin = self.step, self.sin
        if self.scheme.control == "continuous":
            return lambda t, fraction: amplitude * sin(frequency * (t + fraction * h) + phase)
        if self.scheme.control == "mean" and self.rotor.forcing_frequency:
            half = 0.5 * h * frequency
            mean = sin(half) / half
            return lambda t, fraction: amplitude * mean * sin(frequency * t + half + phase)
        at = h * READ_AT.get(self.scheme.control, 0.0)
        return lambda t, fraction: amplitude * sin(frequency * (t + at) + phase)

    def undamped(self) -> Function:
        """Acceleration without damping, by the step's start t, a fraction of it, and theta."""
        pull, push = self.pull(), self.push()
        if self.rotor.autonomous:
            return lambda t, fraction, x: pull(x)
        return lambda t, fraction, x: pull(x) + push(t, fraction)

    def whole(self) -> Function:
        """Acceleration, of theta and its rate."""
        undamped, damping = self.undamped(), self.given[3]
        if not self.rotor.damping_rate:
            return lambda t, fraction, x, v: undamped(t, fraction, x)
        return lambda t, fraction, x, v: undamped(t, fraction, x) - damping * v


def _weight(rotor: DrivenRotor) -> float:
    """Bound on the acceleration without damping, at an angle of 1 rad [rad/s^2]."""
    return sum(
        abs(part)
        for part in (rotor.sin2, rotor.cos, rotor.sin, rotor.stiffness, rotor.forcing_amplitude)
    )


def _plain(
    rotor: DrivenRotor, start: tuple[float, float], scheme: Scheme, step: float, rod: Rod | None
) -> StepMap:
    """A scheme's step with the joint closed."""
    kick = FORCE_ROUNDINGS * step * _weight(rotor)

    def build(coefficients: tuple[Any, ...], sin: Function, cos: Function) -> Step:
        torques = _Torques(rotor, step, scheme, coefficients, sin, cos)

        def observe(x: Any, v: Any) -> tuple[Any, ...]:
            if rod is None:
                return x, v
            return x, v, rod.mass * (rod.length * v * v + rod.gravity * cos(x))

        return Step(_advance(torques), observe)

    def noise(states: Array) -> Array:
        speed = np.abs(states[1])
        return np.array([np.abs(states[0]) + step * speed, speed + kick])

    return StepMap(build, astuple(rotor), start, noise)


def _advance(torques: _Torques) -> Function:
    """The step of a plain scheme, as `errors.rotor_steps` has it."""
    if torques.scheme.integrator == EULER:
        return _euler(torques)
    if torques.scheme.integrator == LEAPFROG:
        return _leapfrog(torques)
    return _runge_kutta(torques, TABLEAUX[torques.scheme.integrator])


def _euler(torques: _Torques) -> Function:
    undamped, whole = torques.undamped(), torques.whole()
    h, scheme, damping, stiffness = torques.step, torques.scheme, *torques.given[3::4]

    def explicit(t: Any, x: Any, v: Any) -> State:
        v = v + h * whole(t, 0.0, x, v)
        return x + h * v, v

    def position_first(t: Any, x: Any, v: Any) -> State:
        x = x + h * v
        return x, v + h * whole(t, 0.0, x, v)

    def implicit(t: Any, x: Any, v: Any) -> State:
        v = (v + h * (undamped(t, 0.0, x) - explicit_rate * v)) / grown
        return x + h * v, v

    if scheme.position_first:
        return position_first
    if not scheme.implicit_damping:
        return explicit
    part = scheme.implicit_damping
    explicit_rate = (1 - part) * damping
    grown = 1.0 + h * part * damping + (h * h * stiffness if scheme.implicit_spring else 0.0)
    return implicit


def _leapfrog(torques: _Torques) -> Function:
    undamped, whole, h, damping = (
        torques.undamped(),
        torques.whole(),
        torques.step,
        torques.given[3],
    )
    half = 0.5 * h
    grown = 1.0 + half * damping

    def advance(t: Any, x: Any, v: Any) -> State:
        v = v + half * whole(t, 0.0, x, v)
        x = x + h * v
        return x, (v + half * undamped(t, 1.0, x)) / grown

    return advance


def _runge_kutta(torques: _Torques, tableau: Tableau) -> Function:
    whole, moved = torques.whole(), along(torques.step)

    def advance(t: Any, x: Any, v: Any) -> State:
        def slopes(fraction: float, state: Sequence[Any]) -> State:
            return state[1], whole(t, fraction, *state)

        return tuple(tableau.advanced(slopes, (x, v), moved))

    return advance


@dataclass(frozen=True)
class _Joint:
    """Numbers of a joint's step (module docstring)."""

    step: Any  # h [s]; numbers, or arrays for many steps
    kept: Any  # 1 - k
    rate: Any  # k / h [1/s]
    part: float  # s
    moment: float  # j
    kick: Any  # rounding of the velocity that gravity adds [rad/s]

    def noise(self, states: Array) -> Array:
        """See `StepMap`."""
        x, w, v, _, _, pull = np.abs(states)
        ones = np.ones_like(x)
        # The rounding of the impulse h T acts on the bob's moment of inertia.
        impulse = self.step * pull / self.moment if self.moment else 0.0 * x
        turning = w + 2.0 * self.rate + impulse
        moved, faster, pulled = x + self.step * w, v + w + self.kick, (w + self.kick) / self.step
        return np.array([moved, turning, faster, 2.0 * ones, 2.0 * ones, pulled])


def _jointed(
    rotor: DrivenRotor, start: tuple[float, float], scheme: Scheme, step: float, rod: Rod | None
) -> StepMap:
    """Euler's step with the position first, of a bob held by a joint (module docstring)."""
    assert scheme.joint_closing_rate is not None
    joint = _joint(rotor, scheme, step, math.expm1)
    theta, theta_dot = start
    opening = 0j
    if math.isinf(scheme.joint_closing_rate):
        opening = _opened(rotor, start, step, lambda angle: complex(np.exp(angle)))

    def build(coefficients: tuple[Any, ...], sin: Function, cos: Function) -> Step:
        return _jointed_step(joint, _Torques(rotor, step, scheme, coefficients, sin, cos), rod)

    return StepMap(
        build,
        astuple(rotor),
        (theta, theta_dot, theta_dot - joint.rate * opening.imag, opening.real, opening.imag, 0.0),
        joint.noise,
    )


def _joint(rotor: DrivenRotor, scheme: Scheme, step: Any, expm1: Function) -> _Joint:
    """The numbers of the joint of `scheme`, for one step [s] or for many."""
    closing = scheme.joint_closing_rate
    assert closing is not None
    closed = 1.0 if math.isinf(closing) else -expm1(-closing * step)
    part = (1.0 + math.sqrt(1.0 - 4.0 * scheme.jointed_moment)) / 2.0
    kick = FORCE_ROUNDINGS * step * _weight(rotor)
    return _Joint(step, 1.0 - closed, closed / step, part, scheme.jointed_moment, kick)


def _opened(rotor: DrivenRotor, start: tuple[float, float], step: Any, exp: Function) -> Any:
    """The opening of a joint that closes in one step, which starts as open as the step before
    would have left it."""
    theta, theta_dot = start
    before = 1j * step * (theta_dot - step * float(rotor.acceleration(0.0, theta, theta_dot)))
    return exp(-before) * (1 + before) - 1


def many_steps(
    rotor: DrivenRotor, start: tuple[float, float], scheme: Scheme, steps: Array
) -> tuple[Callable[..., State], State]:
    """The step of a `scheme` of STEPPED for many sizes at once, `steps` [s] of shape (n,), on
    arrays of that shape, and the state it begins with: the numbers of `start` and, with a joint,
    the bob's velocity, the opening's two parts and the pull."""
    # All of one type: numpy converts a number or a real array anew in each operation.
    steps = steps.astype(complex)
    given = tuple(np.full_like(steps, coefficient) for coefficient in astuple(rotor))
    torques = _Torques(rotor, steps, scheme, given, np.sin, np.cos)
    if scheme.joint_closing_rate is None:
        return _advance(torques), start
    joint = _joint(rotor, scheme, steps, np.expm1)
    opening = np.zeros(len(steps), dtype=complex)
    if math.isinf(scheme.joint_closing_rate):
        opening = _opened(rotor, start, steps, np.exp)
    velocity = start[1] - joint.rate * opening.imag
    begun = (*start, velocity, opening.real, opening.imag, 0.0)
    return _jointed_step(joint, torques, None).advance, begun


def _seen_from(axes: tuple[Any, Any], out: Any, aside: Any) -> tuple[Any, Any]:
    """A vector in axes with this cosine and sine."""
    c, s = axes
    return c * out + s * aside, c * aside - s * out


def _jointed_step(joint: _Joint, torques: _Torques, rod: Rod | None) -> Step:
    push, sin, cos, damping = torques.push(), torques.sin, torques.cos, torques.given[3]
    lever, pulled = joint.step / joint.part, joint.part / joint.step
    weight = lever * torques.given[2]

    def advance(t: Any, x: Any, w: Any, v: Any, a: Any, b: Any, pull: Any) -> State:
        turned = joint.step * w
        axes = cos(turned), sin(turned)
        x, along = x + turned, v + lever * (push(t, 0.0) - damping * w)
        outwards, along = _seen_from(axes, -joint.rate * a, along)
        outwards, along = outwards + weight * cos(x), along - weight * sin(x)
        a, b = _seen_from(axes, 1.0 + joint.kept * a, turned + joint.kept * b)
        a = a - 1.0
        w = w + joint.part * (along - w + joint.rate * b)
        return x, w, w - joint.rate * b, a, b, pulled * (outwards + joint.rate * a)

    def observe(x: Any, w: Any, v: Any, a: Any, b: Any, pull: Any) -> tuple[Any, ...]:
        return (x, w) if rod is None else (x, w, rod.mass * rod.length * pull)

    return Step(advance, observe)
