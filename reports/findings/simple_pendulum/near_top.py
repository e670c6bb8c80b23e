"""Starts next to the top: what scipy's functions and a double of the angle make of them."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from plumbob.analytic.numerics.quad import PI, double, quad
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.models.scene import Scene
from plumbob.reports.findings.saddle_growth import Saddle, saddle_growth
from plumbob.reports.findings.simple_pendulum.problems import SIMPLE, number
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Figure, Finding, Table, row

EXPONENTS = (1, 2, 3, 4, 5, 6, 8, 10, 12)
TIMES = 101  # over a period


def finding() -> Finding:
    """The complement of the angle as the argument, against scipy and against the rounded angle."""
    rows = tuple(_row(k) for k in EXPONENTS)
    lost, gap = _scipy(5), _rounded(12)[2]
    return Finding(
        "near-top",
        "Next to the top the angle itself is no argument: its distance from the top is",
        "measured",
        f"From π – 1e-5 scipy's ellipj puts θ {notation.number(lost)} rad off within a period; a "
        f"double of π – 1e-12 swings up to {notation.number(gap)} rad from the motion that was "
        "asked for. With theta_from_top as the argument the period keeps 15 digits.",
        (
            "The usual θ = 2 arcsin(k sn(K – ωt | m)) has m = sin²(θ₀/2): 1 – 2.5e-11 at 1e-5; "
            "it rounds to 1 from 1e-8 on, and ellipj gives up its period before that. The "
            "closed form here works from the distance to the top, in 34 digits, by arithmetic–"
            "geometric means of the complementary parameter.",
            "No engine has such an argument. Doubles near π are 4.4e-16 rad apart, so that an "
            "engine asked for π – 1e-12 starts up to 2.2e-4 of that distance beside it, and is "
            "early or late by that over the rate √(g/L). The exact answer is that of the distance "
            "asked for; its error bar holds what rounding the start does, and what rounding θ "
            "anew in each step may add.",
        ),
        (
            Table(
                "From rest at π – 10⁻ᵏ, over one period",
                ("k", "period [s]", "scipy's period, relative", "scipy's θ off by [rad]",
                 "distance as a double has it, relative", "its period, relative",
                 "its θ off by [rad]"),
                rows,
                "scipy: ellipk and ellipj of m = sin²(θ₀/2). Off: from the closed form by "
                "theta_from_top, which tests hold against 60-digit quadrature.",
            ),
        ),
        (),
        (
            f"plumbob solve {SIMPLE}near-top-1e-12",
            f"plumbob run {SIMPLE}near-top-1e-12 ode/dop853 --step 1e-13",
        ),
    )  # fmt: skip


@cache
def _problem(k: int) -> tuple[SimplePendulum, PendulumMotion, Array]:
    scene = find_scene(f"{SIMPLE}near-top-1e-{k}")
    problem: SimplePendulum = system_of(scene).problem(scene.parameters)
    motion = problem.elliptic
    assert motion is not None
    return problem, motion, np.linspace(0.0, motion.period, TIMES)


def _row(k: int) -> tuple[Cell, ...]:
    _, motion, _ = _problem(k)
    period = _by_scipy(k, np.zeros(1))[1] / motion.period - 1
    return row(Cell(str(k), "number"), number(motion.period, 16),
               _lost(period), _lost(_scipy(k)), *(number(v, 2) for v in _rounded(k)))  # fmt: skip


def _lost(value: float) -> Cell:
    return number(value, 2) if math.isfinite(value) else Cell("not a number", "number")


def _by_scipy(k: int, times: Array) -> tuple[Array, float]:
    """theta [rad] at `times` [s], shape (n,), and the period [s], by the textbook's formula."""
    import scipy.special

    problem, _, _ = _problem(k)
    rate = math.sqrt(problem.gravity / problem.length)
    parameter = math.sin(problem.started.theta / 2) ** 2
    quarter = float(scipy.special.ellipk(parameter))
    with np.errstate(invalid="ignore"):
        sn = scipy.special.ellipj(quarter - rate * times, parameter)[0]
    return 2 * np.arcsin(math.sqrt(parameter) * sn), 4 * quarter / rate


def _scipy(k: int) -> float:
    """Largest error of theta [rad] over a period by scipy's functions."""
    _, motion, times = _problem(k)
    return float(np.abs(_by_scipy(k, times)[0] - motion.observe(times)["theta"]).max())


def _rounded(k: int) -> tuple[float, float, float]:
    """What a double of the angle does: relative change of the distance from the top and of the
    period, and largest change of theta [rad] over a period."""
    problem, motion, times = _problem(k)
    beside = problem.started.elliptic
    assert beside is not None
    distance = float(double(PI - quad(problem.started.theta)))
    gap = np.abs(beside.observe(times)["theta"] - motion.observe(times)["theta"]).max()
    return (
        distance / -(problem.theta_from_top or math.nan) - 1,
        beside.period / motion.period - 1,
        float(gap),
    )


def hard(study: Study, scene: Scene) -> tuple[Figure | Table, ...]:
    """Growth of the errors at the top, which leaves it at sqrt(g/L)."""
    problem: SimplePendulum = system_of(scene).problem(scene.parameters)
    motion = problem.started.elliptic  # the one whose roundings an engine has
    if motion is None:
        return ()
    top = Saddle(math.pi, math.sqrt(problem.gravity / problem.length))
    note = (
        "The motion starts here, and a step's own error goes as the distance from the top, all "
        "along: such an error grows as t e^(λt), whose fitted rate is above λ by about 1/t. What "
        "rounding leaves at the start grows as e^(λt)."
    )
    return saddle_growth(study, scene, motion, top, note)
