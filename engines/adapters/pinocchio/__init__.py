"""Pinocchio as an engine. Pinocchio computes the accelerations of a mechanism, and has no time
integrator: the integrators are this package's. Errors thus show the accuracy of the equations of
motion alone.

Pinocchio's proximal constraint dynamics closes loops.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from plumbob.analytic.schemes import EULER, RK4, Scheme
from plumbob.engines.abilities import (
    BuildsMechanisms,
    Fields,
    ModelReader,
    RunsFiles,
    SchemeOfCase,
)
from plumbob.engines.adapters.constrained import scheme_unless_constrained
from plumbob.engines.adapters.own_derivatives import derivative_by_mechanisms
from plumbob.engines.method import Engine, Method, Simulation, no_error
from plumbob.models.scene import FREE_ROTATION, ONE_SMOOTH, SMOOTH, Case

if TYPE_CHECKING:
    from plumbob.engines.mechanism import Mechanism
    from plumbob.engines.peer_model import Layout, PeerModel
    from plumbob.engines.stepper import EndDerivatives, SceneMechanism, State, Stepper

KINDS = (ONE_SMOOTH, SMOOTH, FREE_ROTATION)
# Pattern of all systems except for a smooth one whose body touches the ground
UNTOUCHED = "!rolling-disc"
METHODS = (
    Method("pinocchio/aba+euler", Scheme(EULER), 1, systems=(UNTOUCHED,), kinds=KINDS),
    Method(
        "pinocchio/aba+rk4",
        Scheme(RK4),
        4,
        systems=("capsule-line/heading-030", UNTOUCHED),
        kinds=KINDS,
    ),
)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Returns the simulation of `case` by `method` at `step` [s]; raises Unsupported and
    ParameterError."""
    from plumbob.engines.adapters.pinocchio.simulation import prepare

    return prepare(case, method, step)


def _read_fields(path: Path) -> Fields:
    """Returns the fields that Pinocchio's reader takes from a model file; raises NotRead."""
    from plumbob.engines.adapters.pinocchio.user_model import model_fields

    return model_fields(path)


def _load_file(path: Path, layout: Layout, step: float) -> PeerModel:
    """Returns a model file in Pinocchio, to be stepped by `step` [s]; raises NotRead."""
    from plumbob.engines.adapters.pinocchio.user_model import user_model

    return user_model(path, layout, step)


def _build_mechanism(mechanism: Mechanism, start: State, step: float) -> Stepper:
    """Returns the stepper of a mechanism by semi-implicit Euler at `step` [s]; raises
    Unsupported."""
    from plumbob.engines.adapters.pinocchio.stepper import PinocchioStepper

    return PinocchioStepper(mechanism, EULER, step)


def _derivatives(
    scenes: Sequence[SceneMechanism],
    distance: float,
    method: Method,
    step: float,
    duration: float,
) -> EndDerivatives:
    """Returns the derivatives of the end of a run of `duration` [s], see
    `OwnDerivative.of_mechanisms`; raises Unsupported."""
    from plumbob.engines.adapters.pinocchio.derivatives import derivatives

    return derivatives(scenes, distance, method, step, duration)


ENGINE = Engine(
    "pinocchio",
    "pinocchio",
    METHODS,
    prepare,
    no_error,
    optional=True,
    abilities=(
        SchemeOfCase(scheme_unless_constrained),
        ModelReader(_read_fields),
        derivative_by_mechanisms("rnea", _derivatives, 1e-12),
        RunsFiles(_load_file),
        BuildsMechanisms(_build_mechanism, "pinocchio/aba+euler"),
    ),
)
