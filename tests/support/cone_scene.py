"""The cone pendulum of Sudakov 2015 as a system and scene for tests of the engines alone."""

import math
from dataclasses import replace
from pathlib import Path

from plumbob.analytic.systems.cone_pendulum import ConePendulum, solid_cone
from plumbob.models.scene import Observable, Scene, System

MJCF = Path(__file__).parents[2] / "models" / "cone_pendulum" / "cone_pendulum.xml"
DEFAULT = ConePendulum(
    solid_cone(8000.0, 0.3, math.radians(30.0)), 0.0, 0.09, 26.0, 9.8, 0.0, 37.0
)
# Of DEFAULT: theta [rad] at 0.5 s, to 17 digits
THETA = 19.655093168749575


def _problem(parameters):
    return replace(DEFAULT, **parameters)


def _nothing(*_):
    raise NotImplementedError


SYSTEM = System(
    name="cone-pendulum",
    title="Cone pendulum",
    observables=(Observable("theta", "rad"), Observable("theta_dot", "rad/s")),
    parameters=(),
    scenes=(),
    default="",
    problem=_problem,
    reference=lambda problem: problem.motion,
    invariants=_nothing,
    facts=_nothing,
    model_module="plumbob.models.cone_pendulum.model",
    mjcf=MJCF,
    family="cone_pendulum",
)


def scene(duration=0.5, **changes):
    """Scene of DEFAULT with some of its fields changed, for `duration` [s]."""
    return Scene("cone-pendulum/test", "", changes, duration, (), "Sudakov 2015")
