"""Sensitivities of a motion on three Coulomb points: variational equation and saltation.

With the state y = (p, omega, psi, C), see `three_points.equations`, each segment has smooth
equations dy/dt = F(t, y; q) in a parameter q, and S = dy/dq at fixed time obeys S' = F_y S + F_q.
Where the equations change from F- to F+ at a time t_e, which the parameter moves by dt_e/dq,

    S+ = S- + (F- - F+) dt_e/dq                                                                 (1)

(di Bernardo et al. 2008, Piecewise-smooth Dynamical Systems, 2.5). dt_e/dq is

    where the slider's acceleration jumps: that of the piece's start, a formula;
    where support i stops, v_i reaches 0 along its rate a: -(a . dv_i/dq)/a^2;                   (2)
    where a pivot stops turning: -(domega/dq)/omega'.                                          (3)

Where a force reaches the friction limit, and a support slips or rest ends, friction is continuous,
so that F- = F+ and the time does not matter. Where the body comes to rest all velocities vanish
together: S keeps its limit in psi and C, and p and omega stay 0 for all q near. As v_i -> 0 its
direction e settles where e is parallel to a(e) (`three_points.sliding`), and F_y grows as 1/|v_i|
across e only; a segment's own variable, in which its state is a polynomial, resolves that. But the
polynomials have absolute errors, and e is lost as v_i falls to round-off. There ln v_i = ln rho +
i theta, with the variable's clock d sigma = dt (a + sum b_j/|v_j|), is solved again from

    d(ln v_i)/d sigma = e* dv_i/dt/(a rho + b_i + rho sum_(j not i) b_j/|v_j|).                  (4)

S approaches its limit as a power of rho, which may be a small one: (4) goes on, with everything but
v_i as it is, far beyond round-off, until S no longer changes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from plumbob.analytic.numerics.collocation import TimeGrid, collocate, evaluate, gauss_collocation
from plumbob.analytic.numerics.rotor.linear_flow import LinearFlow
from plumbob.analytic.numerics.rotor.variational import Response
from plumbob.analytic.reference import Array
from plumbob.analytic.sensitivities.neighbours import Derived, Neighbours, Sensitivity, stacked
from plumbob.analytic.sensitivities.smooth_motion import read_along
from plumbob.analytic.systems.capsule import by_support, normal_forces
from plumbob.analytic.systems.three_points.equations import (
    Complex,
    Configuration,
    Slide,
    configuration,
)
from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.analytic.systems.three_points.pivoting import Pivot
from plumbob.analytic.systems.three_points.smooth_segment import SmoothSegment, monotone_root

STAGES, FEWER = 28, 22  # of the collocation in a segment, and of the one that shows its error
AMPLIFIED = 32.0  # times the relative error of the motion: that of its derivatives
SLOW = 1e-4  # speed of a support over the largest, below which its direction is solved again
NUDGE = 1e-6  # of ln v_i, for derivatives that Newton's method needs
FURTHER, ELEMENTS = 8.0, 80  # length in sigma, and number, of elements beyond round-off
SETTLED = 1e-15  # relative change of S in one of them, after which it is settled
TURNS = 30  # of Newton's method for the direction in which a support stops
Columns = Array  # S of all parameters, then the effect of their uncertainties: (6, 2 parameters)


@dataclass(frozen=True)
class SlidingBody:
    """One neighbour: a motion, which only the first of them integrates, its heading in the world at
    the start [rad], and the velocity of C [m/s] and the turning [rad/s] at the start."""

    motion: ThreePointMotion
    heading: float
    velocity: complex
    omega: float

    def configured(self, number: int, times: Array) -> Configuration:
        """The slider's part at `times` [s] since the start, on piece `number` and its analytic
        continuation."""
        local = times - self.motion.path.breakpoints[number]
        return configuration(self.motion.body, self.motion.piece(number), local)

    @property
    def start(self) -> Array:
        """State at time 0, shape (6,)."""
        at = self.configured(0, np.zeros(1))
        point = self.velocity + 1j * self.omega * self.motion.body.mass_ratio * at.position[0]
        return np.array([point.real, point.imag, self.omega, 0.0, 0.0, 0.0])

    def read(self, times: Array, states: Array) -> Mapping[str, Array]:
        """Observables, as `PlaneReference` names them, from `states`, shape (6, n)."""
        px, py, omega, psi, x, y = states
        mu, places = self.motion.body.mass_ratio, self.motion.path.kinematics(times)[0]
        along, across = px + omega * mu * places[:, 1], py - omega * mu * places[:, 0]
        cos, sin = np.cos(psi), np.sin(psi)
        return {
            "body_angle": psi,
            "x": x,
            "y": y,
            "velocity_x": cos * along - sin * across,
            "velocity_y": sin * along + cos * across,
            "heading": psi + self.heading,
            "heading_rate": omega,
            **by_support(normal_forces(self.motion.capsule, places)),
        }


def _moved(slider: Configuration, ratio: float, state: Array) -> Array:
    """Rates of psi and of C, shape (3, n), in `state` (p_x, p_y, omega, psi, ...), shape (6, n)."""
    speed = state[0] + 1j * state[1] - 1j * state[2] * ratio * slider.position
    drift = speed * np.exp(1j * state[3])
    return np.stack([state[2], drift.real, drift.imag])


@dataclass(frozen=True)
class _Nodes:
    """Times [s], states, shape (6, n), and the slider's part at the nodes of a segment, dt over its
    variable, directions of sliding, and v_i at the end of a support that is about to stop."""

    times: Array
    state: Array
    at: Configuration
    pace: Array
    slide: Slide | None = None
    end: complex = 0j


@dataclass(frozen=True)
class _Slowing:
    """Eq. 4 at the nodes of a segment of `size` in sigma, as `collocate` calls it: of ln v_i of a
    `support` as two numbers, shape (n, 2)."""

    here: SlidingBody
    nodes: _Nodes
    support: int
    given: tuple[float, Array] | None
    size: float

    @property
    def clock(self) -> tuple[float, Array]:
        """The variable's, a and b_i."""
        assert self.given is not None
        return self.given

    def slide(self, logarithms: Array) -> Slide:
        """The sliding with this ln v_i."""
        assert self.nodes.slide is not None
        velocity = np.exp(logarithms @ [1.0, 1j])
        return self.nodes.slide.slower(self.nodes.at, self.support, velocity)

    def slopes(self, logarithms: Array) -> Array:
        """Rates of ln v_i over the segment, shape (n, 2)."""
        slide, nodes, (steady, shares) = self.slide(logarithms), self.nodes, self.clock
        rates = slide.rates(self.here.motion.body, nodes.at, nodes.state[3])
        rate = _support_rates(self.here, rates.T, nodes.state[2], nodes.at, self.support)
        speed = slide.speeds[:, self.support]
        pace = self.size / (steady * speed + (speed[:, None] / slide.speeds) @ shares)
        slopes = slide.back[:, self.support] * rate * pace
        return np.column_stack([slopes.real, slopes.imag])

    def __call__(self, logarithms: Array, derived: bool) -> tuple[Array, Array]:
        slopes = self.slopes(logarithms)
        if not derived:
            return slopes, slopes
        steps = NUDGE * np.eye(2)
        by = [(self.slopes(logarithms + step) - slopes) / NUDGE for step in steps]
        return slopes, np.stack(by, axis=-1)


@dataclass(frozen=True)
class _Segment:
    """A segment of the motion with its equations, for neighbours too."""

    bodies: Sequence[Neighbours[SlidingBody]]
    segment: SmoothSegment
    axes: float  # heading of the start in the motion's own axes [rad]
    entering: complex = 0j  # v_i of the support that is about to stop [m/s], 0 where none is

    @property
    def here(self) -> SlidingBody:
        return self.bodies[0].here

    @property
    def began(self) -> float:
        """Start of the slider's piece [s]."""
        return float(self.here.motion.path.breakpoints[self.segment.piece])

    def states(self, places: Array) -> tuple[Array, Array]:
        """Times [s], shape (n,), and states, shape (6, n), at `places` of the segment's variable;
        C is left 0, on which nothing depends."""
        assert self.segment.coefficients is not None
        px, py, omega, local, psi, *_ = evaluate(self.segment.coefficients, places).T
        zero = np.zeros_like(px)
        return local + self.began, np.stack([px, py, omega, psi - self.axes, zero, zero])

    @cached_property
    def sense(self) -> float:
        """Direction in which a pivot turns."""
        return float(np.sign(self.states(np.array([0.5 * self.segment.last]))[1][2, 0]))

    def _sliding(self, body: SlidingBody, at: Configuration, state: Array, slide: Slide) -> Array:
        rates = slide.rates(body.motion.body, at, state[3])[:, :3].T
        return np.concatenate([rates, _moved(at, body.motion.body.mass_ratio, state)])

    def _pivoting(self, body: SlidingBody, at: Configuration, state: Array) -> Array:
        of, support = body.motion.body, self.segment.support
        pivot = Pivot(of, body.motion.piece(self.segment.piece), support, self.sense)
        turning = pivot.motion(at, state[2], state[3]).omega_rate
        point = -1j * (turning * at.arms[:, support] - state[2] * of.mass_ratio * at.velocity)
        rates = np.stack([point.real, point.imag, turning])
        return np.concatenate([rates, _moved(at, of.mass_ratio, state)])

    @cached_property
    def _speeds(self) -> Array:
        """|v_i| at the end of a slide over the largest of them, shape (3,)."""
        times, state = self.states(np.array([self.segment.last]))
        at = self.here.configured(self.segment.piece, times)
        speeds = Slide.of(self.here.motion.body, at, state[:3].T).speeds[0]
        return np.asarray(speeds / speeds.max())

    @property
    def stopping(self) -> int:
        """The support whose v_i is lost in round-off towards the end, -1 where there is none."""
        solution = self.segment.solution
        if self.segment.mode != "slide" or solution is None or solution.clock is None:
            return -1
        slow = np.flatnonzero(self._speeds < SLOW)
        return int(slow[0]) if slow.size == 1 else -1

    def _nodes(self, stages: int) -> _Nodes:
        """Where the collocation evaluates the equations."""
        coefficients, last = self.segment.coefficients, self.segment.last
        assert coefficients is not None
        places = last * gauss_collocation(stages).nodes
        times, state = self.states(places)
        clock = 2.0 * legendre.legder(coefficients[:, 3])
        pace = legendre.legval(2.0 * places - 1.0, clock)
        at = self.here.configured(self.segment.piece, times)
        if self.segment.mode == "pivot":
            return _Nodes(times, state, at, pace)
        slide = Slide.of(self.here.motion.body, at, state[:3].T)
        if self.stopping < 0:
            return _Nodes(times, state, at, pace, slide)
        return self._slowing(_Nodes(times, state, at, pace, slide), stages)

    def _slowing(self, nodes: _Nodes, stages: int) -> _Nodes:
        """Nodes with the v_i of the support that stops from eq. 4."""
        solution, last = self.segment.solution, self.segment.last
        assert solution is not None
        size = last * solution.size
        slowing = _Slowing(self.here, nodes, self.stopping, solution.clock, size)
        rule, begin = gauss_collocation(stages), np.log(self._entered)
        start = np.array([begin.real, begin.imag])
        guess = np.tile(slowing.slopes(np.tile(start, (stages, 1)))[:1], (stages, 1))
        slopes = collocate(rule, slowing, start, guess, np.ones(2))
        if slopes is None:
            return nodes
        slide = slowing.slide(start + rule.integral @ slopes)
        state = np.concatenate([[slide.point.real, slide.point.imag], nodes.state[2:]])
        end = complex(np.exp((start + rule.weights @ slopes) @ [1.0, 1j]))
        pace = solution.size * slide.pace(slowing.clock)
        return _Nodes(nodes.times, state, nodes.at, pace, slide, end)

    @property
    def _entered(self) -> complex:
        """v_i at the start of the support that is about to stop [m/s]."""
        if self.entering:
            return self.entering
        times, state = self.states(np.zeros(1))
        at = self.here.configured(self.segment.piece, times)
        arm = at.arms[0, self.stopping]
        return complex(state[0, 0] + 1j * state[1, 0] + 1j * state[2, 0] * arm)

    def _equations(self, nodes: _Nodes) -> tuple[Array, list[Derived]]:
        """F_y at nodes, shape (n, 6, 6), and F_q by each parameter, shape (6, n)."""
        number, times, state, at = self.segment.piece, nodes.times, nodes.state, nodes.at
        body, jacobian = self.here.motion.body, np.zeros((times.size, 6, 6))
        _carry(jacobian, state, at, body.mass_ratio)
        if nodes.slide is not None:
            jacobian[:, :3, :3] = nodes.slide.derivatives(body, at, None)[:, :3]
            return jacobian, [self._by(bodies, nodes, nodes.slide) for bodies in self.bodies]

        def turning(one: SlidingBody) -> Array:
            return self._pivoting(one, one.configured(number, times), state)

        faster = state + np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])[:, None]
        # Affine in omega: a difference is exact.
        change = self._pivoting(self.here, at, faster) - turning(self.here)
        jacobian[:, :3, 2] = change[:3].T
        return jacobian, [bodies.derivative(turning) for bodies in self.bodies]

    def _by(self, bodies: Neighbours[SlidingBody], nodes: _Nodes, slide: Slide) -> Derived:
        """F_q of sliding: with the directions of sliding kept, and by their turning, since v_i at
        a fixed (p, omega) depends on the parameter too."""
        number, body, times = self.segment.piece, self.here.motion.body, nodes.times

        def kept(one: SlidingBody) -> Array:
            there = one.configured(number, times)
            return self._sliding(one, there, nodes.state, slide.elsewhere(one.motion.body, there))

        values, uncertain = bodies.derivative(kept)
        arms, _ = _complex(bodies, lambda one: one.configured(number, times).arms)
        moved = 1j * nodes.state[2][:, None] * arms
        values[:3] += slide.turned_by(body, nodes.at, moved).T
        return values, uncertain

    def response(self, start: Columns, stages: int) -> tuple[Response, complex]:
        """S over the segment's variable from `start`, and v_i of the support that is about to stop
        at its end [m/s]."""
        nodes = self._nodes(stages)
        jacobian, by = self._equations(nodes)
        forcing = stacked(by).transpose(1, 0, 2)
        pace = nodes.pace[:, None, None]
        flow = LinearFlow(TimeGrid(np.array([0.0, self.segment.last])), (pace * jacobian)[None])
        return flow.respond(start, (pace * forcing)[None]), nodes.end

    def places(self, times: Array) -> Array:
        """The segment's variable at `times` [s]."""
        begin, end = self.segment.start, self.segment.end
        assert self.segment.coefficients is not None
        local = np.clip(times - self.began, begin, end)
        return monotone_root(self.segment.coefficients[:, 3], local, self.segment.last)

    def rates_at(self, place: float, stopping: tuple[int, ...] = ()) -> Array:
        """F at a place, shape (6,), in the limit where the supports `stopping` stop."""
        times, state = self.states(np.array([place]))
        at, body = self.here.configured(self.segment.piece, times), self.here.motion.body
        if self.segment.mode == "pivot":
            return self._pivoting(self.here, at, state)[:, 0]
        slide = Slide.of(body, at, state[:3].T)
        for support in stopping:
            slide = self._settled(slide, at, state, support)
        return self._sliding(self.here, at, state, slide)[:, 0]

    def _settled(self, slide: Slide, at: Configuration, state: Array, support: int) -> Slide:
        """The directions of sliding with that of `support`, which round-off hides, where e is
        parallel to its own rate."""

        def turned(angle: float) -> tuple[Slide, float]:
            back = slide.back.copy()
            back[0, support] *= np.exp(-1j * angle)
            there = Slide(
                slide.point, slide.omega, slide.speeds, back, back * at.arms, slide.widening
            )
            rates = self._sliding(self.here, at, state, there)
            rate = _support_rates(self.here, rates, state[2], at, support)[0]
            return there, float((back[0, support] * rate).imag / abs(rate))

        angle, step = 0.0, 1e-4
        for _ in range(TURNS):
            off = turned(angle)[1]
            slope = (turned(angle + step)[1] - turned(angle - step)[1]) / (2 * step)
            change = -off / slope
            angle += float(np.clip(change, -0.3, 0.3))
            if abs(change) < 1e-15:
                break
        return turned(angle)[0]

    def departure(self) -> Array:
        """F at the segment's start, shape (6,), from its polynomials: where a support starts from
        rest its direction of sliding is a limit."""
        assert self.segment.coefficients is not None
        slopes = np.asarray(legendre.legder(self.segment.coefficients, axis=0), dtype=np.float64)
        px, py, omega, clock, *_ = evaluate(slopes, np.zeros(1))[0]
        times, state = self.states(np.zeros(1))
        at = self.here.configured(self.segment.piece, times)
        rest = _moved(at, self.here.motion.body.mass_ratio, state)[:, 0]
        return np.array([px / clock, py / clock, omega / clock, *rest])


def _support_rates(
    here: SlidingBody, rates: Array, omega: Array, at: Configuration, support: int
) -> Complex:
    """dv_i/dt of a support [m/s^2], shape (n,), where the state has the `rates`, shape (6, n)."""
    drift = 1j * omega * here.motion.body.mass_ratio * at.velocity
    return np.asarray(rates[0] + 1j * rates[1] + 1j * rates[2] * at.arms[:, support] - drift)


def _carry(jacobian: Array, state: Array, at: Configuration, ratio: float) -> None:
    """Fill in the derivatives of the rates of psi and C by the state, in place."""
    turn = np.exp(1j * state[3])
    speed = state[0] + 1j * state[1] - 1j * state[2] * ratio * at.position
    jacobian[:, 3, 2] = 1.0
    by = (turn, 1j * turn, -1j * ratio * at.position * turn, 1j * speed * turn)
    for column, values in enumerate(by):
        jacobian[:, 4, column], jacobian[:, 5, column] = values.real, values.imag


def _complex(
    bodies: Neighbours[SlidingBody], read: Callable[[SlidingBody], Any]
) -> tuple[Complex, Array]:
    """The derivative of plane vectors, and its uncertainty."""
    real, one = bodies.derivative(lambda body: read(body).real)
    imaginary, other = bodies.derivative(lambda body: read(body).imag)
    return real + 1j * imaginary, one + other


def sliding_gradients(bodies: Sequence[Neighbours[SlidingBody]], times: Array) -> list[Sensitivity]:
    """Sensitivities at `times` [s], shape (n,), by each parameter."""
    here, count = bodies[0].here, len(bodies)
    found, coarse = (_walk(bodies, times, stages) for stages in (STAGES, FEWER))
    missed = np.abs(found - coarse)[..., :count] + np.abs(found[..., count:])
    missed += AMPLIFIED * _lost(here.motion) * np.abs(found[..., :count]).max(axis=0)
    states = _states(here, times)
    return [
        read_along(one, times, states, found[..., k].T, missed[..., k].T)
        for k, one in enumerate(bodies)
    ]


def _lost(motion: ThreePointMotion) -> float:
    """Error of the motion's velocities over the fastest of the supports."""
    begins = motion.begins
    middles = np.append((begins[1:] + begins[:-1]) / 2, begins)
    error, pose = motion.error, motion.at(middles)
    reach = float(np.abs(motion.body.supports).max())
    speed = np.hypot(*pose.velocity.T).max() + reach * np.abs(pose.angular_velocity).max()
    off = np.abs(error.velocity).max() + reach * np.abs(error.angular_velocity).max()
    return float(off / speed) if speed else 0.0


def _states(here: SlidingBody, times: Array) -> Array:
    """The states of the motion at `times` [s], shape (6, n), in the axes of the start."""
    begin, pose = here.motion.at(np.zeros(1)), here.motion.at(times)
    back = np.exp(-1j * begin.heading[0])
    place = (pose.position - begin.position) @ [1.0, 1j] * back
    psi = pose.heading - begin.heading[0]
    slider = here.motion.path.kinematics(times)[0] @ [1.0, 1j]
    arm = 1j * pose.angular_velocity * here.motion.body.mass_ratio * slider
    point = pose.velocity @ [1.0, 1j] * back * np.exp(-1j * psi) + arm
    return np.stack([point.real, point.imag, pose.angular_velocity, psi, place.real, place.imag])


def _walk(bodies: Sequence[Neighbours[SlidingBody]], times: Array, stages: int) -> Array:
    """S at `times`, shape (n, 6, 2 parameters), from event to event."""
    begins, until = bodies[0].here.motion.begins, float(times.max(initial=0.0))
    which = np.clip(np.searchsorted(begins, times, side="right") - 1, 0, None)
    found = np.zeros((times.size, 6, 2 * len(bodies)))
    for number, (segment, columns, response) in enumerate(_segment_by_segment(bodies, stages)):
        if begins[number] > until:
            break
        inside = which == number
        if response is None:
            found[inside] = columns
        else:
            found[inside] = response.at(segment.places(times[inside]))
    return found


def _segment_by_segment(
    bodies: Sequence[Neighbours[SlidingBody]], stages: int
) -> Iterator[tuple[_Segment, Columns, Response | None]]:
    """Each segment, S at its start and, where the body moves, S over its variable."""
    motion = bodies[0].here.motion
    axes = float(motion.at(np.zeros(1)).heading[0])
    columns = stacked([one.derivative(lambda body: body.start) for one in bodies])
    before, slowing = None, 0j
    for smooth in motion.segments:
        segment = _Segment(bodies, smooth, axes, slowing)
        if before is not None:
            if slowing and _stopping(before.segment, smooth):
                columns = _settled_columns(before, columns, slowing, stages)
            columns = saltation(before, segment, columns)
        if smooth.coefficients is None:
            yield segment, columns, None
            slowing = 0j
        else:
            response, slowing = segment.response(columns, stages)
            yield segment, columns, response
            columns = response.end
        before = segment


def _settled_columns(before: _Segment, columns: Columns, slowing: complex, stages: int) -> Columns:
    """S in the limit where a support stops, from S at the end of the slide, where it is still at
    `slowing` [m/s]."""
    segment = before.segment
    assert segment.coefficients is not None
    assert segment.solution is not None
    end = evaluate(segment.coefficients, np.array([segment.last]))
    further = replace(segment.solution, size=FURTHER)
    still = replace(segment, coefficients=end, last=1.0, solution=further)
    for _ in range(ELEMENTS):
        ahead = replace(before, segment=still, entering=slowing)
        response, slowing = ahead.response(columns, stages)
        change = np.abs(response.end - columns).max(axis=0)
        columns = response.end
        if (change <= SETTLED * np.abs(columns).max(axis=0)).all() or not slowing:
            break
    return columns


def saltation(before: _Segment, after: _Segment, columns: Columns) -> Columns:
    """S after the event between two segments, eq. 1, from S before it."""
    left, right = before.segment, after.segment
    same = left.mode == right.mode and left.piece == right.piece
    if same and (right.support < 0 if right.mode == "slide" else right.support == left.support):
        return columns
    stopping = _stopping(left, right)
    ended, begun = _before(before, stopping), _after(left, after)
    delays = _delays(before, after, columns, ended, stopping)
    found = columns + np.outer(ended - begun, delays)
    if right.mode == "rest":
        found[:3] = 0.0
    return found


def _stopping(left: SmoothSegment, right: SmoothSegment) -> tuple[int, ...]:
    """The support that stops where one segment follows another on the same piece."""
    if left.mode != "slide" or left.piece != right.piece or right.support < 0:
        return ()
    return (right.support,)


def _before(before: _Segment, stopping: tuple[int, ...]) -> Array:
    """F at the end of a segment, shape (6,)."""
    if before.segment.mode == "rest":
        return np.zeros(6)
    return before.rates_at(before.segment.last, stopping)


def _after(left: SmoothSegment, after: _Segment) -> Array:
    """F at the start of a segment that follows `left`, shape (6,)."""
    right = after.segment
    if right.mode == "rest":
        return np.zeros(6)
    if right.mode == "slide" and (left.mode != "slide" or right.support >= 0):
        return after.departure()
    return after.rates_at(0.0)


def _delays(
    before: _Segment, after: _Segment, columns: Columns, ended: Array, stopping: tuple[int, ...]
) -> Array:
    """dt_e/dq of the event between two segments [s per unit], shape (2 parameters,)."""
    left, right = before.segment, after.segment
    if left.piece != right.piece:
        moved = [
            bodies.derivative(lambda one: one.motion.path.breakpoints[right.piece])
            for bodies in before.bodies
        ]
        return stacked(moved)
    if left.mode == "pivot" and (right.mode != "slide"):
        return np.asarray(-columns[2] / ended[2])
    if not stopping:
        return np.zeros(columns.shape[1])
    return _stop_delays(before, columns, ended, stopping[0])


def _stop_delays(before: _Segment, columns: Columns, ended: Array, support: int) -> Array:
    """Eq. 2 of a slide that ends as `support` stops, shape (2 parameters,)."""
    times, state = before.states(np.array([before.segment.last]))
    number = before.segment.piece
    at = before.here.configured(number, times)
    rate = complex(_support_rates(before.here, ended[:, None], state[2], at, support)[0])
    moved = columns[0] + 1j * columns[1] + 1j * columns[2] * at.arms[0, support]
    arms = [
        _complex(bodies, lambda one: one.configured(number, times).arms[0, support])
        for bodies in before.bodies
    ]
    shifts = np.array([*(arm for arm, _ in arms), *(unsure for _, unsure in arms)])
    moved = moved + 1j * state[2, 0] * shifts
    return np.asarray(-(np.conj(rate) * moved).real / abs(rate) ** 2)
