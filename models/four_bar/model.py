"""The relation of a four-bar linkage to four_bar.xml."""

from __future__ import annotations

from typing import Any

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.four_bar import FourBar
from plumbob.models.idealisations import Idealisations
from plumbob.models.model_file import ModelFile
from plumbob.models.n_pendulum import model as n_pendulum


def fill(spec: Any, bars: FourBar) -> None:
    """Writes the numbers of a linkage into an MjSpec of four_bar.xml: three rods in a chain, and
    the two points that the pin joins."""
    n_pendulum.fill(spec, bars.chain)
    spec.site("end").pos = [0.0, 0.0, -bars.rocker]
    spec.site("axis").pos = [bars.ground, 0.0, 0.0]


def ideal(bars: FourBar) -> Idealisations:
    """Returns the idealisation: the pin of the rocker is rigid."""
    return Idealisations(rigid_loops=("pin",))


def observe(bars: FourBar, qpos: Array, qvel: Array) -> Signals:
    """Returns the crank's angle and rate, and the coupler's place."""
    return n_pendulum.chain_observables(bars.open_chain, qpos, qvel)


MODEL = ModelFile(fill, observe, ideal)
