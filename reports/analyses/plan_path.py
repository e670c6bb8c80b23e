"""The figures of one plan: the path of the body from above, its heading over time, the slider."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.planner.result import Plan
from plumbob.reports.view.content import Figure
from plumbob.reports.view.palette import BLUE, GREEN, GREY, RED
from plumbob.reports.view.traces import Trace, curve, figure, linear, over_time

KINDS: Mapping[str, tuple[str, str]] = MappingProxyType({
    "turn": (RED, "turns"), "line": (BLUE, "lines"),
    "slow": (GREEN, "slow motions"), "wait": (GREY, "residual motions"),
})  # fmt: skip
POINTS = 40  # of each manoeuvre


def gallery(plan: Plan) -> tuple[str, tuple[Figure, ...]]:
    """A plan from above, the heading over time, and the slider in the body."""
    goal = plan.goal
    heading = (
        f"A plan to {goal.x:g}, {goal.y:g} m and {goal.heading:.4g} rad "
        f"({plan.turns} turns, {plan.lines} lines, {plan.duration:.3g} s)"
    )
    return heading, (_from_above(plan), _heading(plan), _slider(plan))


def _times(plan: Plan, number: int) -> Array:
    one = plan.manoeuvres[number]
    return np.linspace(one.start, one.start + one.duration, POINTS)


def _by_kind(plan: Plan, x: Any, y: Any, width: float = 2.4) -> list[Trace]:
    """A curve for each kind of manoeuvre, with gaps; `x` and `y` take times [s]."""
    traces: list[Trace] = []
    for kind, (colour, label) in KINDS.items():
        chosen = [n for n, one in enumerate(plan.manoeuvres) if one.kind == kind]
        for place, number in enumerate(chosen):
            times = _times(plan, number)
            one = curve(x(times), y(times), colour=colour, width=width, name=label)
            traces.append({**one, "legendgroup": kind, "showlegend": place == 0})
    return traces


def _from_above(plan: Plan) -> Figure:
    """Path of C on the ground, with the triangle of the supports at rest poses between turns."""
    motion = plan.motion

    def position(times: Array) -> Array:
        return np.asarray(motion.at(times).position)

    traces = _by_kind(plan, lambda t: position(t)[:, 0], lambda t: position(t)[:, 1])
    reached: list[complex] = []
    shown = [0.0, *(end for end, one in zip(plan.ends, plan.manoeuvres, strict=True)
                    if one.kind in ("wait", "line"))]  # fmt: skip
    corners = np.array([complex(*point) for point in plan.capsule.supports])
    for number, time in enumerate(shown):
        at = motion.at(np.array([time]))
        placed = complex(*at.position[0]) + corners * np.exp(1j * at.heading[0])
        first = number == 0
        last = number == len(shown) - 1
        loop = np.append(placed, placed[0])
        reached += loop.tolist()
        traces.append({
            **curve(loop.real, loop.imag, colour=GREY, width=2.0 if first or last else 0.7,
                    dash="dot" if first else "solid",
                    name="start" if first else "goal" if last else "on the way"),
            "opacity": 1.0 if first or last else 0.5,
            "showlegend": first or last or number == 1,
        })  # fmt: skip
        tip = placed[0]
        traces.append({
            **curve([tip.real], [tip.imag], colour=GREY, marks=True, lines=False,
                    hint=f"A1 at {time:.3g} s"),
            "showlegend": False,
        })  # fmt: skip
    return figure(
        "From above",
        "Path of the body's centre of mass C, and the triangle of its supports A₁A₂A₃ where it is "
        "at rest; a dot at A₁.",
        traces, linear("x [m]", constrain="domain", range=_axis_range([z.real for z in reached])),
        linear("y [m]", scaleanchor="x", constrain="domain",
               range=_axis_range([z.imag for z in reached])), legend=True, height=430,
    )  # fmt: skip


def _axis_range(values: list[float]) -> list[float]:
    """Ends of an axis that shows all of them."""
    low, high = min(values), max(values)
    return [low - 0.06 * (high - low), high + 0.06 * (high - low)]


def _heading(plan: Plan) -> Figure:
    traces = _by_kind(plan, lambda t: t, lambda t: plan.motion.at(t).heading)
    return over_time(
        "Heading over time",
        "Turns change it; lines and slow motions do not; a residual motion ends a turn.",
        traces, linear("ψ [rad]"), height=430,
    )  # fmt: skip


def _slider(plan: Plan) -> Figure:
    """The slider's path in the body."""

    def place(times: Array) -> Array:
        return plan.slider(times)

    traces = _by_kind(plan, lambda t: place(t)[:, 0], lambda t: place(t)[:, 1])
    round_about = np.linspace(0.0, 2.0 * math.pi, 90)
    radius = plan.limits.radius
    traces.append(curve(radius * np.cos(round_about), radius * np.sin(round_about),
                        colour=GREY, dash="dot", width=0.8, name="circle"))  # fmt: skip
    return figure(
        "The slider in the body",
        "In body axes, from C; turns run on the circle.",
        traces, linear("along the body's x [m]", constrain="domain"),
        linear("along its y [m]", scaleanchor="x", constrain="domain"), legend=True, height=430,
    )  # fmt: skip
