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
from plumbob.reports.analyses.cone_pendulum.hamiltonian import MUJOCO, ROTATING, cone
from plumbob.reports.analyses.measurements import PERIODS, period

PIVOTS = (0.0, 0.09)  # [m] y of the pivot
RATES = (0.0, 4.0, 8.0, 16.0, 26.0)  # [rad/s] platform rates of the runs
SWING = 1e-3  # [rad] amplitude, which changes the relative rate by less than 1e-6
STEP = 5e-4  # [s]
DRAWN = np.linspace(0.0, 30.0, 121)  # [rad/s] platform rates of the diagrams


def centres() -> list[tuple[float, float, Equilibrium]]:
    """Returns (y of the pivot [m], platform rate [rad/s], equilibrium) for each stable equilibrium
    at each of PIVOTS and RATES."""
    stable = list[tuple[float, float, Equilibrium]]()
    for pivot, rate in product(PIVOTS, RATES):
        equilibria = cone(pivot_y=pivot, platform_rate=rate).equilibria
        stable += [(pivot, rate, e) for e in equilibria if e.kind == "centre"]
    return stable


def _request(pivot: float, rate: float, centre: Equilibrium) -> ExtraRun:
    """Returns MuJoCo's run of a small swing about a stable equilibrium."""
    changes: Changes = (
        ("pivot_y", pivot),
        ("platform_rate", rate),
        ("theta", centre.theta - SWING),
        ("theta_dot", 0.0),
    )
    return ExtraRun(ROTATING, MUJOCO, STEP, PERIODS * 2 * np.pi / centre.rate, changes)


def numbers(study: Study) -> Record:
    """Returns the bifurcation diagrams, and the rates of small swings, exact and in MuJoCo."""
    rows = []
    for pivot, rate, centre in centres():
        swing_period = period(study.answer(_request(pivot, rate, centre)), centre.theta)
        measured = None if swing_period is None else 2 * np.pi / swing_period
        row = Record(
            pivot=pivot,  # [m]
            platform_rate=rate,  # [rad/s]
            theta=centre.theta,  # [rad]
            rate=centre.rate,  # [rad/s] exact rate of small swings
            measured=measured,  # [rad/s] rate of small swings in MuJoCo
            gap=None if measured is None else measured / centre.rate - 1.0,  # relative error
        )
        rows.append(row)
    level = cone(pivot_y=PIVOTS[0], platform_rate=26.0)
    offset = cone(pivot_y=PIVOTS[-1], platform_rate=26.0)
    gaps = [abs(row.gap) for row in rows if row.gap is not None]
    return Record(
        centres=rows,
        diagrams=[_diagram(pivot) for pivot in PIVOTS],
        # [rad/s] platform rate of the pitchfork, for the first of PIVOTS
        fork=level.pitchfork_rate,
        node=offset.saddle_node_rate,  # [rad/s] rate of the saddle-node, for the last of PIVOTS
        largest_gap=max(gaps, default=None),
        offset=PIVOTS[-1],
        swing=SWING,
        scene=ROTATING,
    )


def claims(numbers: Record) -> Claims:
    """Returns the check that the measured rates agree with the exact ones."""
    gap = np.nan if numbers.largest_gap is None else numbers.largest_gap
    return (at_most("the largest difference of a rate, relative,", gap, AGREES),)


def _diagram(pivot: float) -> Record:
    """Returns all equilibria for one pivot: platform rates [rad/s] and angles [rad], separately for
    stable and unstable ones."""
    by_kind = {kind: Record(rates=[], angles=[]) for kind in ("centre", "saddle")}
    for rate in DRAWN.tolist():
        for equilibrium in cone(pivot_y=pivot, platform_rate=rate).equilibria:
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
