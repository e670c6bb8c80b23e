"""How a problem of a system stands in the system's model file, and how the file's coordinates show
the observables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from plumbob.analytic.reference import Array, Signals
from plumbob.models.idealisations import NONE, Idealisations

Controls = Callable[[Array], Array]
"""Controls of the file's actuators at times [s], shape (n,): shape (n, controls)."""


@dataclass(frozen=True)
class ModelFile:
    """Functions of a problem and the model file of its system. `fill` takes an MjSpec of the file,
    whose keyframe "start" gets the start of the motion; coordinates are MuJoCo's."""

    fill: Callable[[Any, Any], None]
    """Writes the numbers of a problem into an MjSpec of the file, in place."""
    observe: Callable[[Any, Array, Array], Signals]
    """The observables of a problem that positions, shape (n, nq), and velocities, shape (n, nv),
    show: all but forces, shape (n,) each."""
    ideal: Callable[[Any], Idealisations] = lambda problem: NONE
    """The idealisations of a problem, which the file cannot state."""
    controls: Callable[[Any], Controls | None] = lambda problem: None
    """The controls of a problem; None where they stay zero."""
    largest: Callable[[Any], Mapping[str, float]] = lambda problem: {}
    """Magnitudes of observables that only a diverged run exceeds."""
    forces: Callable[[Any, Array, Array, Array, Array], Signals] | None = None
    """The observables of a problem that are forces, shape (n,) each, by positions, velocities, and
    an engine's forces [N] along the world's axes: of each joint on the body that it moves, shape
    (n, joints, 3), and of the first shape of each pair that touches on the second, shape
    (n, pairs, 3). They are of the step that ends at a sample, and nan at the start."""
    variant: Callable[[Any], str] = lambda problem: ""
    """The name of the file beside the system's that has a problem's bodies; empty where the
    system's own file has them."""
