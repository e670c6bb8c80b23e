"""Whether a turning platform makes rotation more uniform: the finding, by three measures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.analytic.systems.pendulums.uniformity import (
    Uniformity,
    from_below,
    of_motion,
    of_samples,
)
from plumbob.engines.study.extra_runs import Changes, ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.cone_pendulum.hamiltonian import MUJOCO, MUJOCO_STEP, ROTATING
from plumbob.reports.view.content import Figure, Finding, Statement, Table, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.sources import SUDAKOV
from plumbob.reports.view.traces import figure, linear, logarithmic, rounded

# pivot_y [m], platform rate [rad/s], theta_dot [rad/s]: each turning platform beside one at rest
POINTS = ((0.0, 0.0, 13.0), (0.0, 8.0, 13.0), (0.09, 0.0, 37.0), (0.09, 10.0, 37.0),
          (0.09, 26.0, 37.0))  # fmt: skip
RATES = tuple(float(rate) for rate in np.linspace(0.0, 30.0, 41))  # [rad/s] of the platform
SPEEDS = tuple(float(speed) for speed in np.geomspace(12.75, 60.0, 36))  # [rad/s]
PIVOTS = (0.0, 0.09)  # [m]


@dataclass(frozen=True)
class Map:
    """The measures over platform rates, shape (speeds, rates), against those at rest."""

    pivot_y: float
    turning: Uniformity
    resting: Uniformity  # shape (speeds, 1)

    @property
    def by_deviation(self) -> Array:
        """Deviation over that at rest: below 1 the platform makes the rotation more uniform."""
        return self.turning.deviation / self.resting.deviation

    @property
    def by_time(self) -> Array:
        """The platform's addition to the part of the time within 5 % of the initial speed."""
        return self.turning.near - self.resting.near

    @property
    def by_spread(self) -> Array:
        """Spread over that at rest: never below 1."""
        return self.turning.spread / self.resting.spread


def _request(point: tuple[float, float, float]) -> ExtraRun:
    pivot, rate, speed = point
    changes: Changes = (("pivot_y", pivot), ("platform_rate", rate), ("theta_dot", speed))
    return ExtraRun(ROTATING, MUJOCO, MUJOCO_STEP, problem(point).motion.period, changes)


@cache
def problem(point: tuple[float, float, float]) -> ConePendulum:
    """The source's cone at a point of POINTS."""
    names = ("pivot_y", "platform_rate", "theta_dot")
    changes = dict(zip(names, point, strict=True))
    return case_of(find_scene(ROTATING, changes)).problem  # type: ignore[no-any-return]


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """A turn of MuJoCo's full model at each of a few points."""
    return tuple(_request(point) for point in POINTS)


@cache
def exact(point: tuple[float, float, float]) -> Uniformity:
    """The measures of the closed form at a point of POINTS."""
    return of_motion(problem(point).motion)


@cache
def over_rates(pivot_y: float) -> Map:
    """The map of a pivot [m]."""
    start = problem((pivot_y, 1.0, SPEEDS[0]))
    v = start.potential  # its a and b grow with the square of the rate
    squares = np.array(RATES) ** 2
    potential = TrigonometricPotential(
        float(double(v.a)) * squares, float(double(v.b)) * squares, float(double(v.c)) + 0 * squares
    )
    speeds = np.array(SPEEDS)[:, None]
    turning = from_below(potential, start.body.inertia_x, speeds + 0 * squares)
    resting = from_below(
        TrigonometricPotential(0.0, 0.0, float(double(v.c))), start.body.inertia_x, speeds
    )
    return Map(pivot_y, turning, resting)


def finding(study: Study) -> Finding:
    """Three measures, three verdicts, and where on the map each holds."""
    maps = [over_rates(pivot) for pivot in PIVOTS]
    still, better, far_rest, far = (exact(point) for point in POINTS[:4])
    lowest = min(float(np.nanmin(drawn.by_spread)) for drawn in maps)
    verdicts = (
        ("largest less smallest speed", "refuted", "never smaller than at rest: V(0) and V(π) are "
         "the same at every ω and Y, and at rest they are the extremes"),
        ("standard deviation over mean", "holds in a regime", f"{_digits(better.deviation)} "
         f"against {_digits(still.deviation)} at rest (Y 0, ω 8, 13 rad/s)"),
        ("time within 5 % of the initial speed", "holds in a regime",
         f"{_percent(better.near)} against {_percent(still.near)} there, {_percent(far.near)} "
         f"against {_percent(far_rest.near)} (Y 0.09, ω 10, 37 rad/s)"),
    )  # fmt: skip
    return Finding(
        "uniformity",
        "Whether a turning platform makes rotation more uniform depends on the measure",
        "split",
        "Whether a turning platform makes a rotation smoother depends on how that is "
        "measured. "
        "From θ = 0 with the same initial speed the range of speeds never shrinks; the standard "
        "deviation and the time near the initial speed do improve in a regime, just above the "
        "barrier and on slow platforms.",
        (
            "The source says that a regime exists in which a turning base makes the rotation more "
            "uniform. V(0) = –c and V(π) = +c at every platform rate and pivot, so that from θ = 0 "
            "the speeds at the bottom and at the top do not depend on the platform. On a platform "
            "at rest they are the largest and the smallest, on a turning one both still occur: the "
            "range is at least as large. (On the maps the smallest ratio is "
            f"{number(lowest, 8)}.)",
            "The passage of the slow top can still be shorter, and then the other two measures "
            "improve: the standard deviation over "
            f"{_percent(_part(maps[0].by_deviation < 1.0))} of "
            f"the map for Y = 0 and {_percent(_part(maps[1].by_deviation < 1.0))} for Y = 0.09 m, "
            f"the time near the initial speed over {_percent(_part(maps[0].by_time > 0.0))} and "
            f"{_percent(_part(maps[1].by_time > 0.0))}.",
        ),
        (
            Table(
                "The claim, by measure",
                ("measure", "verdict", "why"),
                tuple(row(*line) for line in verdicts),
            ),
            _points(study),
        ),
        tuple(_figures(maps)),
        (
            f"plumbob solve {ROTATING} --set pivot_y=0 --set platform_rate=8 --set theta_dot=13",
            f"plumbob run {ROTATING} {MUJOCO} --step {MUJOCO_STEP:g} --set pivot_y=0 "
            "--set platform_rate=8 --set theta_dot=13",
        ),
        (
            Statement(
                SUDAKOV,
                "Fig. 3 e",
                "In some regime a turning base makes the rotation more uniform",
                "more uniform",
                f"by the range of speeds never (at least "
                f"{number(lowest, 8)} times that at rest); by the standard deviation and by the "
                f"time near the initial speed it does: {_digits(better.deviation)} against "
                f"{_digits(still.deviation)}, {_percent(better.near)} against "
                f"{_percent(still.near)}",
                "corrected" if lowest > 1.0 - 1e-9 else "holds",
            ),
        ),
    )  # fmt: skip


def _points(study: Study) -> Table:
    rows = []
    for point in POINTS:
        ran, right = study.recording(_request(point)), exact(point)
        pivot, rate, speed = point
        where = f"Y {number(pivot)} m, ω {number(rate)}, {number(speed)} rad/s"
        cells = [value(float(x), 4) for x in (right.spread, right.deviation, right.near)]
        speeds = None if ran is None else of_samples(ran.times, ran.observables["theta_dot"])
        run = (None,) * 3 if speeds is None else (speeds.spread, speeds.deviation, speeds.near)
        cells += [value(None if x is None else float(x), 4) for x in run]
        rows.append(row(where, *cells))
    names = ("spread", "deviation", "within 5 %")
    heads = ("start", *(f"{n}, exact" for n in names), *(f"{n}, MuJoCo" for n in names))
    return Table("At a few points: closed form and MuJoCo's full model", heads, tuple(rows))


def _figures(maps: Sequence[Map]) -> list[Figure]:
    figures = []
    for drawn in maps:
        pivot = f"Y = {number(drawn.pivot_y)} m"
        for title, values, middle, note in (
            ("Standard deviation over that at rest", drawn.by_deviation, 1.0,
             "Blue: the platform makes the rotation more uniform."),
            ("Time near the initial speed, less that at rest", -drawn.by_time, 0.0,
             "With the sign changed, so that blue is more uniform here too."),
            ("Range of speeds over that at rest", drawn.by_spread, 1.0, "Nowhere below 1."),
        ):  # fmt: skip
            # beyond twice the value at rest the colour says enough
            shown = np.clip(values, middle - 0.5, middle + 0.5)
            figures.append(
                figure(
                    f"{title}, {pivot}",
                    f"{note} White: no difference, or no rotation.",
                    [_heat(shown, middle)],
                    linear("platform rate ω [rad/s]"),
                    logarithmic("initial speed θ̇₀ [rad/s]"),
                    height=300,
                )
            )
    return figures


def _heat(values: Array, middle: float) -> Mapping[str, Any]:
    return {
        "type": "heatmap",
        "x": rounded(RATES),
        "y": rounded(SPEEDS),
        "z": [rounded(line) for line in values],
        "zmin": middle - 0.5,
        "zmax": middle + 0.5,
        "colorscale": [[0.0, "#0072b2"], [0.5, "#ffffff"], [1.0, "#d55e00"]],
        "colorbar": {"thickness": 10},
    }


def _part(where: Any) -> float:
    return float(np.mean(where))


def _digits(amount: Array) -> str:
    return number(float(amount))


def _percent(part: float | Array) -> str:
    return f"{100 * float(part):.3g} %"
