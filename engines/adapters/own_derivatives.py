"""Parts that engines' own derivatives share: cases with a nudged number, and derivatives of the
observables at the end of a run."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from plumbob.analytic.numerics.smooth.smooth_system import IMAGINARY_STEP
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Signals
from plumbob.engines.abilities import OwnDerivative
from plumbob.engines.adapters.stepped_mechanism import compiled_scene, model_file
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.trajectory import ByName
from plumbob.models.scene import Case

if TYPE_CHECKING:
    from plumbob.engines.abilities import OfMechanisms
    from plumbob.models.gradient import Number

NUDGE = 1e-6  # relative change of a number, or of a state


def nudged(number: Number) -> tuple[tuple[Case, Case, Case], float]:
    """Three cases, with a number a little smaller, unchanged and a little larger, and the
    difference of the number between the outer cases. Raises Unsupported if a case is not
    possible."""
    low, middle, high = (number.value + side * NUDGE * number.size for side in (-1, 0, 1))
    try:
        return (number.moved(low), number.moved(middle), number.moved(high)), high - low
    except ParameterError as error:
        raise Unsupported(str(error)) from None


def moved(observe: Callable[..., Signals], *slopes: Array) -> ByName:
    """The derivatives of observables along the `slopes` of the positions and of the velocities of a
    state, by central differences.

    `observe` returns the observables of the state whose positions and velocities are moved along
    their slopes by two given amounts. Positions and velocities are moved one after the other, and
    the two derivatives are added: a small slope would be lost in the rounding of a large one.
    """
    derivatives: dict[str, float] = {}
    largest = [max(float(abs(slope).max()), IMAGINARY_STEP) for slope in slopes]
    lengths = [NUDGE / size for size in largest]
    # A row moves the positions alone, or the velocities alone.
    for amounts, length in zip(np.diag(lengths), lengths, strict=True):
        low = observe(*-amounts)
        high = observe(*amounts)
        for name in high:
            change = float(high[name][0] - low[name][0]) / (2 * length)
            derivatives[name] = derivatives.get(name, 0.0) + change
    return derivatives


def derivative_by_mechanisms(
    way: str, of_mechanisms: OfMechanisms, precision: float
) -> OwnDerivative:
    """The ability of an engine whose way takes mechanisms, for scenes too."""
    of_number = partial(by_mechanisms, of_mechanisms)
    return OwnDerivative(way, of_number, precision, of_mechanisms=of_mechanisms)


def by_mechanisms(
    of_mechanisms: OfMechanisms, number: Number, method: Method, step: float
) -> ByName:
    """The derivatives of the observables of a case at its end by a way that takes mechanisms;
    raises Unsupported."""
    cases, apart = nudged(number)
    scenes = [compiled_scene(case) for case in cases]
    case = number.case
    end = of_mechanisms(scenes, apart, method, step, case.scene.duration)

    def observe(place: float, rate: float) -> Signals:
        """The observables of the end, moved along its slopes by two amounts."""
        qpos = (end.qpos + place * end.by_qpos)[None]
        qvel = (end.qvel + rate * end.by_qvel)[None]
        return model_file(case).observe(case.problem, qpos, qvel)

    return moved(observe, end.by_qpos, end.by_qvel)
