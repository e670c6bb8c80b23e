"""Equilibria against the platform's rate, and small oscillations about them, exact and measured."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from plumbob.analytic.systems.cone_pendulum import ConePendulum, Equilibrium
from plumbob.engines.study.extra_runs import Changes, ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.findings.cone_pendulum.hamiltonian import MUJOCO, ROTATING
from plumbob.reports.findings.measurements import PERIODS, swing_period
from plumbob.reports.findings.sources import SUDAKOV
from plumbob.reports.view.content import Figure, Finding, Statement, Table, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import BLUE, RED
from plumbob.reports.view.site.claims import AGREES, at_most
from plumbob.reports.view.traces import figure, linear, marks

PIVOTS = (0.0, 0.09)  # [m]
RATES = (0.0, 4.0, 8.0, 16.0, 26.0)  # [rad/s]
SWING = 1e-3  # [rad], amplitude: the rate changes by less than 1e-6, relative
STEP = 5e-4  # [s]


@cache
def still(pivot: float, rate: float) -> ConePendulum:
    """The source's cone on a platform at a `rate` [rad/s], its pivot at `pivot` [m]."""
    scene = find_scene(ROTATING, {"pivot_y": pivot, "platform_rate": rate})
    return case_of(scene).problem  # type: ignore[no-any-return]


def centres() -> list[tuple[float, float, Equilibrium]]:
    """Pivot, rate and each stable equilibrium there."""
    return [
        (pivot, rate, equilibrium)
        for pivot in PIVOTS
        for rate in RATES
        for equilibrium in still(pivot, rate).equilibria
        if equilibrium.kind == "centre"
    ]


def _request(pivot: float, rate: float, centre: Equilibrium) -> ExtraRun:
    changes: Changes = (
        ("pivot_y", pivot),
        ("platform_rate", rate),
        ("theta", centre.theta - SWING),
        ("theta_dot", 0.0),
    )
    return ExtraRun(ROTATING, MUJOCO, STEP, PERIODS * 2 * np.pi / centre.rate, changes)


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Three small swings of MuJoCo's full model about each stable equilibrium."""
    return tuple(_request(*where) for where in centres())


def finding(study: Study) -> Finding:
    """Both bifurcations, and how well MuJoCo's small swings have the exact rates."""
    level, offset = (still(pivot, 26.0) for pivot in PIVOTS)
    rows, gaps = [], []
    for pivot, rate, centre in centres():
        period = swing_period(study.recording(_request(pivot, rate, centre)), centre.theta)
        dots = None if period is None else 2 * np.pi / period
        gap = None if dots is None else dots / centre.rate - 1.0
        gaps += [] if gap is None else [abs(gap)]
        rows.append(
            row(
                value(pivot, 2), value(rate, 2), value(centre.theta, 6), value(centre.rate, 8),
                value(dots, 8), value(gap, 2),
            )
        )  # fmt: skip
    heads = ("Y [m]", "ω [rad/s]", "θ of the equilibrium [rad]", "rate, exact [rad/s]",
             "rate, MuJoCo [rad/s]", "relative difference")  # fmt: skip
    within = f"{number(max(gaps, default=0.0), 2)}, relative"
    fork, node = number(level.pitchfork_rate, 6), number(offset.saddle_node_rate, 6)
    return Finding(
        "equilibria",
        "Two equilibria become four: a pitchfork for a pivot on the axis, else a saddle–node",
        "extended",
        "Above a critical platform rate hanging straight down is no longer stable: linearise "
        "about another point. "
        f"With the pivot on the platform's axis hanging stops being stable at {fork} rad/s; with "
        f"Y = {number(PIVOTS[1])} m a second pair appears at {node} rad/s."
        + (f" Rates of small swings in MuJoCo agree to {within}." if gaps else ""),
        (
            "The source recalls that the singular points and the rates of small oscillation about "
            "them are what is usually found, and that there may be two on a moving base. V' and "
            "V'' are zero together where (2a)^⅔ = b^⅔ + c^⅔. With a and b proportional to ω² this "
            "is one rate: ω² = c/((I_y – I_z)^⅔ – (MYS)^⅔)^(3/2). The swings have an amplitude "
            f"of {number(SWING)} rad, which changes their rate by less than 1e-6, relative.",
        ),
        (Table("Stable equilibria and the rates of small swings", heads, tuple(rows)),),
        tuple(_figure(pivot) for pivot in PIVOTS),
        (
            f"plumbob solve {ROTATING} --set pivot_y=0 --set platform_rate=8",
            f"plumbob solve {ROTATING} --set platform_rate=16",
        ),
        (
            Statement(
                SUDAKOV,
                "introduction",
                "On a moving base there may be two stable equilibria, with small oscillations",
                "two",
                f"two from {fork} rad/s (Y = 0) and {node} rad/s (Y = {number(PIVOTS[1])} m)"
                + (f"; rates in MuJoCo within {within}" if gaps else ""),
                "extended",
            ),
        ),
        claims=(
            at_most(
                "the largest difference of a rate, relative,", max(gaps, default=np.nan), AGREES
            ),
        ),
    )


def _figure(pivot: float) -> Figure:
    """Equilibria over the platform's rate: stable and unstable."""
    places: dict[str, list[tuple[float, float]]] = {"centre": [], "saddle": []}
    for rate in np.linspace(0.0, 30.0, 121):
        for equilibrium in still(pivot, float(rate)).equilibria:
            if equilibrium.kind in places:
                places[equilibrium.kind].append((float(rate), equilibrium.theta))
    traces = [
        marks([x for x, _ in places[kind]], [y for _, y in places[kind]], colour, name, size=3)
        for kind, colour, name in (("centre", BLUE, "stable"), ("saddle", RED, "unstable"))
    ]
    return figure(
        f"Equilibria against the platform's rate, Y = {number(pivot)} m",
        "A pitchfork at θ = 0." if pivot == 0.0 else "A saddle–node pair away from the first.",
        traces,
        linear("platform rate ω [rad/s]"),
        linear("θ [rad]"),
        legend=True,
    )
