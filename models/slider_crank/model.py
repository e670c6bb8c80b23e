"""The relation of a slider-crank to slider_crank.xml."""

from __future__ import annotations

from typing import Any

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.slider_crank import SliderCrank
from plumbob.models.idealisations import Idealisations
from plumbob.models.model_file import ModelFile


def fill(spec: Any, mechanism: SliderCrank) -> None:
    """Writes the numbers of a slider-crank into an MjSpec of slider_crank.xml."""
    spec.option.gravity = [0.0, 0.0, -mechanism.gravity]
    stretched = mechanism.crank + mechanism.rod
    _set_link(spec, "crank", mechanism.crank, mechanism.crank_mass)
    _set_link(spec, "rod", mechanism.rod, mechanism.rod_mass)
    spec.body("rod").pos = [mechanism.crank, 0.0, 0.0]
    spec.body("slider").pos = [stretched, 0.0, 0.0]
    spec.body("slider").mass = mechanism.slider_mass
    pin = spec.equality("pin")
    pin.data = [mechanism.rod, 0.0, 0.0, *pin.data[3:]]
    start = spec.key("start")
    crank, rod, slider = mechanism.open_chain.position
    start.qpos = [crank, rod - crank, slider - stretched]
    crank, rod, slider = mechanism.open_chain.rate
    start.qvel = [crank, rod - crank, slider]


def _set_link(spec: Any, name: str, length: float, mass: float) -> None:
    """Makes a link a uniform thin rod. The inertia about the rod's own axis has no effect: the
    motion is planar."""
    link = spec.body(name)
    link.mass = mass
    link.ipos = [length / 2, 0.0, 0.0]
    link.inertia = [mass * length**2 / 12] * 3
    spec.geom(name).fromto = [0.0, 0.0, 0.0, length, 0.0, 0.0]


def ideal(mechanism: SliderCrank) -> Idealisations:
    """Returns the idealisation: the pin between rod and slider is rigid."""
    return Idealisations(rigid_loops=("pin",))


def observe(mechanism: SliderCrank, qpos: Array, qvel: Array) -> Signals:
    """Returns the crank's angle and rate, and the slider's distance from the crank's axis."""
    stretched = mechanism.crank + mechanism.rod
    return {"angle": qpos[:, 0], "angle_dot": qvel[:, 0], "slider": stretched + qpos[:, 2]}


MODEL = ModelFile(fill, observe, ideal)
