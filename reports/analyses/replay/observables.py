"""Replays of systems that have no picture of their own: the observables over time."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.models.scene import Case
from plumbob.reports.analyses.replay.picture import Chart, Picture, around, observed
from plumbob.reports.analyses.replay.samples import Channels
from plumbob.reports.view.notation import number

MOST = 3  # observables that are drawn


def chart(case: Case, seconds: float) -> Picture:
    """The replay of any system over `seconds` [s]: its first observables as charts."""
    shown = {o.name: o.unit for o in case.system.observables[:MOST]}
    first = next(iter(shown))
    motion, deviations = observed(case.reference.observe, list(shown))
    exact = motion(np.linspace(0.0, seconds, 801))

    def apart(differences: Channels) -> Array:
        return np.abs(differences[first])

    return Picture(
        "chart",
        f"{', '.join(shown)} over time.",
        (-0.1, 1.7, -0.1, 1.1),
        {"trail": 0.0},
        tuple(
            Chart(f"{name} [{unit}]", "t", (name,), (0.0, seconds, *around(exact[name])))
            for name, unit in shown.items()
        ),
        frozenset({first}),
        frozenset({first}),
        float(np.ptp(exact[first])) or 1.0,
        motion,
        deviations,
        apart,
        lambda errors: f"{number(float(apart(errors).max()))} {shown[first]}",
    )
