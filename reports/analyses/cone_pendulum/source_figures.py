"""Figs. 2 and 3 of the source, a to e: the printed curves, the corrected ones, and MuJoCo's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.analytic.systems.pendulums.tilted_motion import TiltedMotion
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    MUJOCO,
    MUJOCO_STEP,
    RESTING,
    ROTATING,
    forms,
)
from plumbob.reports.analyses.energy_drift import in_double
from plumbob.reports.view.content import Figure
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import BLUE, GREY, RED
from plumbob.reports.view.traces import Trace, curve, figure, linear, marks

TURN = 2 * np.pi
DOTS = 40  # of the engine's run, over one period
POINTS = 241  # of a curve
Curve = tuple[Array, Array]
ANGLE, TIME = "angle θ / 2π", "time t / T"


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """A period of MuJoCo's full model on either base."""
    return tuple(_period(scene) for scene in (RESTING, ROTATING))


def _period(scene: str) -> ExtraRun:
    return ExtraRun(scene, MUJOCO, MUJOCO_STEP, forms(scene).correct.period)


def galleries(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    """Fig. 2, on a resting base, and Fig. 3, on a turning one."""
    return (
        (
            "Fig. 2 of the source: a platform at rest, printed and corrected agree",
            panels(study, RESTING),
        ),
        (
            "Fig. 3 of the source: a platform at 26 rad/s, printed and corrected",
            panels(study, ROTATING),
        ),
    )


def panels(study: Study, scene: str) -> tuple[Figure, ...]:
    """The panels of a scene, with MuJoCo's run among the curves."""
    both, engine = forms(scene), study.recording(_period(scene))
    data = None if engine is None else _seen(engine, both.correct.period)
    return _panels(both.problem, both.printed, data)


def solved(case: Case) -> tuple[Figure, ...]:
    """The panels for any parameters."""
    problem = case.problem.started
    return _panels(problem, problem.printed_motion(), None)


def _panels(
    problem: ConePendulum, printed: PendulumMotion, data: tuple[Array, Array, Array] | None
) -> tuple[Figure, ...]:
    """Panels a to e with the source's axes: angle over 2 pi, time over each motion's own period."""
    inertia, right = problem.body.inertia_x, problem.motion
    both = (_Course(problem.reference, right), _Course(printed, printed))
    momentum, speed = "momentum p [kg m² rad/s]", "dθ/dt [rad/s]"
    dots = [None] * 4 if data is None else [
        (data[1], data[0]), (data[1], inertia * data[2]), (data[0], inertia * data[2]),
        (data[0], data[2]),
    ]  # fmt: skip
    periods = f"T = {number(right.period, 6)} s; printed: {number(printed.period, 6)} s."
    return (
        _barrier(problem, printed),
        _panel("b: t(θ)", periods, (ANGLE, TIME), [_time_of_angle(m) for m in both], dots[0]),
        _panel(
            "c: p(θ)",
            "The phase curve from the start on.",
            (ANGLE, momentum),
            [_momentum_of_angle(m) for m in both],
            dots[1],
        ),
        _panel(
            "d: p(t)",
            "b and c, with θ as the parameter.",
            (TIME, momentum),
            [_over_time(m, inertia) for m in both],
            dots[2],
        ),
        _panel(
            "e: dθ/dt(t)",
            "d over the moment of inertia.",
            (TIME, speed),
            [_over_time(m, 1.0) for m in both],
            dots[3],
        ),
    )


def _panel(
    title: str, caption: str, axes: tuple[str, str], pair: Sequence[Curve], dots: Curve | None
) -> Figure:
    traces = _pair(*pair)
    if dots is not None:
        traces.append(marks(*dots, GREY, "MuJoCo"))
    x, y = map(linear, axes)
    return figure(title, caption, traces, x, y, legend=True, height=300)


def _pair(right: Curve, printed: Curve) -> list[Trace]:
    return [
        curve(*right, colour=BLUE, width=2.2, name="corrected"),
        curve(*printed, colour=RED, dash="dash", width=2.2, name="printed"),
    ]


def _barrier(problem: ConePendulum, printed: PendulumMotion) -> Figure:
    """V(theta), and the energy of each motion, which has to stay above its V."""
    right, offset = problem.motion, problem.potential_offset
    theta = np.linspace(0.0, TURN, POINTS)
    wells = problem.potential_at(theta), np.asarray(in_double(printed.potential).value(theta))
    traces = _pair(*((theta / TURN, well) for well in wells))
    levels = [float(double(right.energy)) + offset, float(double(printed.energy))]
    for level, colour, dash, name in (
        (levels[0], BLUE, "solid", "H₀ corrected"),
        (levels[1], RED, "dash", "H₀ printed"),
    ):
        line = curve([0.0, 1.0], [level, level], colour=colour, dash=dash, width=1.0, name=name)
        traces.append({**line, "showlegend": False})
    tops = [float(well.max()) for well in wells]
    for i, (motion, add) in enumerate(((right, offset), (printed, 0.0))):
        if motion.barriers.size:
            tops[i] = float(double(motion.barriers[0])) + add
    caption = f"Barrier {tops[0]:.3f} J, printed {tops[1]:.3f} J; thin: H₀ = {levels[0]:.3f} J."
    return figure("a: V(θ)", caption, traces, linear(ANGLE), linear("V [J]"), legend=True,
                  height=300)  # fmt: skip


@dataclass(frozen=True)
class _Course:
    """A motion as the figures show it, and the one that has its period."""

    seen: PendulumMotion | TiltedMotion
    whole: PendulumMotion

    @property
    def span(self) -> float:
        """The unit of the time axis [s]: a period; on a separatrix, and at rest, 1."""
        return self.whole.period if np.isfinite(self.whole.period) else 1.0


def _time_of_angle(course: _Course) -> Curve:
    theta = np.linspace(0.0, TURN, POINTS)
    return theta / TURN, course.seen.time_at(theta) / course.span


def _momentum_of_angle(course: _Course) -> Curve:
    theta = np.linspace(0.0, TURN, POINTS)
    return theta / TURN, course.seen.momentum(theta)


def _over_time(course: _Course, factor: float) -> Curve:
    times = np.linspace(0.0, course.span, POINTS)
    return times / course.span, factor * course.seen.state(times)[1]


def _seen(run: Trajectory, period: float) -> tuple[Array, Array, Array]:
    """t / T, theta / 2 pi and theta_dot at a few samples of the engine's run."""
    kept = np.unique(np.linspace(0, len(run.times) - 1, DOTS).astype(int))
    theta, rate = run.observables["theta"], run.observables["theta_dot"]
    return run.times[kept] / period, theta[kept] / TURN, rate[kept]
