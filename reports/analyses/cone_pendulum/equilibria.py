"""Equilibria over the platform's rate, and small oscillations about them, exact and measured."""

from __future__ import annotations

from itertools import product

import numpy as np

from plumbob.analytic.systems.cone_pendulum import Equilibrium
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.request import Changes
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import AGREES, Claims, at_most
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    FULL_MODEL_METHOD,
    ROTATING,
    turning_cone,
)
from plumbob.reports.analyses.measurements import MEASURED_PERIODS, period

EQUILIBRIUM_PIVOTS = (0.0, 0.09)  # [m] y of the pivot
RUN_RATES = (0.0, 4.0, 8.0, 16.0, 26.0)  # [rad/s] platform rates of the runs
SMALL_SWING = 1e-3  # [rad] amplitude, which changes the relative rate by less than 1e-6
EQUILIBRIA_STEP = 5e-4  # [s]
# [rad/s] a platform rate for the rates of the pitchfork and of the saddle-node, which do not depend
# on it
ANY_RATE = RUN_RATES[-1]
DIAGRAM_RATES = np.linspace(0.0, 30.0, 121)  # [rad/s] platform rates of the diagrams


def centres() -> list[tuple[float, float, Equilibrium]]:
    """Returns (y of the pivot [m], platform rate [rad/s], equilibrium) for each centre, which is a
    stable equilibrium, at each of EQUILIBRIUM_PIVOTS and RUN_RATES."""
    stable = list[tuple[float, float, Equilibrium]]()
    for pivot, rate in product(EQUILIBRIUM_PIVOTS, RUN_RATES):
        equilibria = turning_cone(pivot_y=pivot, platform_rate=rate).equilibria
        stable += [(pivot, rate, e) for e in equilibria if e.kind == "centre"]
    return stable


def _request(pivot: float, rate: float, centre: Equilibrium) -> ExtraRun:
    """Returns MuJoCo's run of a small swing about a stable equilibrium."""
    changes: Changes = (
        ("pivot_y", pivot),
        ("platform_rate", rate),
        ("theta", centre.theta - SMALL_SWING),
        ("theta_dot", 0.0),
    )
    return ExtraRun(
        ROTATING,
        FULL_MODEL_METHOD,
        EQUILIBRIA_STEP,
        MEASURED_PERIODS * 2 * np.pi / centre.rate,
        changes,
    )


def numbers(study: Study) -> Record:
    """Returns the bifurcation diagrams, and the rates of small swings, exact and in MuJoCo."""
    rows = []
    for pivot, rate, centre in centres():
        measured, gap = _measured_rate(study, pivot, rate, centre)
        row = Record(
            pivot=pivot,  # [m]
            platform_rate=rate,  # [rad/s]
            theta=centre.theta,  # [rad]
            rate=centre.rate,  # [rad/s] exact rate of small swings
            measured=measured,  # [rad/s] rate of small swings in MuJoCo
            gap=gap,  # relative error of the measured rate
        )
        rows.append(row)
    cone_on_axis = turning_cone(pivot_y=EQUILIBRIUM_PIVOTS[0], platform_rate=ANY_RATE)
    cone_off_axis = turning_cone(pivot_y=EQUILIBRIUM_PIVOTS[-1], platform_rate=ANY_RATE)
    gaps = [abs(row.gap) for row in rows if row.gap is not None]
    return Record(
        centres=rows,
        diagrams=[_diagram(pivot) for pivot in EQUILIBRIUM_PIVOTS],
        # [rad/s] platform rate of the pitchfork, for the first of EQUILIBRIUM_PIVOTS
        fork=cone_on_axis.pitchfork_rate,
        # [rad/s] rate of the saddle-node, for the last of EQUILIBRIUM_PIVOTS
        node=cone_off_axis.saddle_node_rate,
        largest_gap=max(gaps, default=None),
        offset=EQUILIBRIUM_PIVOTS[-1],
        swing=SMALL_SWING,
        scene=ROTATING,
    )


def _measured_rate(
    study: Study, pivot: float, rate: float, centre: Equilibrium
) -> tuple[float | None, float | None]:
    """Returns the rate of small swings about a stable equilibrium in MuJoCo [rad/s], and its
    relative error; None for both if they were not measured."""
    swing_period = period(study.answer(_request(pivot, rate, centre)), centre.theta)
    if swing_period is None:
        return None, None
    measured = 2 * np.pi / swing_period
    return measured, measured / centre.rate - 1.0


def claims(numbers: Record) -> Claims:
    """Returns the check that the measured rates agree with the exact ones."""
    gap = np.nan if numbers.largest_gap is None else numbers.largest_gap
    return (at_most("the largest difference of a rate, relative,", gap, AGREES),)


def _diagram(pivot: float) -> Record:
    """Returns all equilibria for one pivot: platform rates [rad/s] and angles [rad], separately for
    stable and unstable ones."""
    by_kind = {kind: Record(rates=[], angles=[]) for kind in ("centre", "saddle")}
    for rate in DIAGRAM_RATES.tolist():
        for equilibrium in turning_cone(pivot_y=pivot, platform_rate=rate).equilibria:
            if equilibrium.kind in by_kind:
                by_kind[equilibrium.kind].rates.append(rate)
                by_kind[equilibrium.kind].angles.append(equilibrium.theta)
    return Record(
        pivot=pivot,  # [m]
        stable=by_kind["centre"],
        unstable=by_kind["saddle"],
    )


EQUILIBRIA = Analysis(
    "cone_pendulum/equilibria",
    numbers,
    lambda plan: tuple(_request(*centre) for centre in centres()),
    claims,
)
