"""The relation of a problem to its system's model file: how the file gets the problem's numbers,
and how the file's coordinates show the observables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.sampled_control import SamplingTimes
from plumbob.models.idealisations import NO_IDEALISATIONS, Idealisations

Controls = Callable[[Array], Array]
"""Returns the controls of the file's actuators, shape (n, controls), at times [s], shape (n,), some
of which may lie beyond the end of the scene."""


@dataclass(frozen=True)
class Feedback:
    """A controller that is asked with the state of the run itself. Its answers are held."""

    times: SamplingTimes
    answer: Callable[[float, Array, Array], Array]
    """Returns the controls of the file's actuators, shape (controls,), at a time [s] and in a state
    with positions of shape (nq,) and velocities of shape (nv,)."""
    controls: int  # number of controls, which are zero until the first answer acts


@dataclass(frozen=True)
class ModelFile:
    """Functions that relate a problem to the model file of its system. Coordinates are MuJoCo's.
    `fill` takes an MjSpec of the file; it writes the start of the motion into the keyframe
    "start"."""

    fill: Callable[[Any, Any], None]
    """Writes the numbers of a problem into an MjSpec of the file, in place."""
    observe: Callable[[Any, Array, Array], Signals]
    """Returns all observables but forces, shape (n,) each, of a problem at positions, shape
    (n, nq), and velocities, shape (n, nv)."""
    ideal: Callable[[Any], Idealisations] = lambda problem: NO_IDEALISATIONS
    """Returns the idealisations of a problem, which the file cannot state."""
    controls: Callable[[Any], Controls | Feedback | None] = lambda problem: None
    """Returns the controls of a problem, or what feeds them back; None if they stay zero."""
    largest: Callable[[Any], Mapping[str, float]] = lambda problem: {}
    """Returns magnitudes of observables that only a diverged run exceeds."""
    forces: Callable[[Any, Array, Array, Array, Array], Signals] | None = None
    """Returns the observables of a problem that are forces [N], shape (n,) each. Its arguments are
    the problem, positions, velocities, and an engine's forces [N] along the world's axes: the force
    of each joint on the body that it moves, shape (n, joints, 3), and for each pair of shapes in
    contact the force of the first on the second, shape (n, pairs, 3). An engine's forces at a
    sample are those of the step that ends there; they are nan at the start."""
    variant: Callable[[Any], str] = lambda problem: ""
    """Returns the name of another file in the same folder that has a problem's bodies; empty if the
    system's own file has them."""
