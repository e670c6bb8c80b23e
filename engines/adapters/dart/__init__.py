"""DART as an engine: articulated bodies in double precision, stepped by semi-implicit Euler.
Acceleration actuators prescribe the motion of joints, and velocity constraints close loops.

Contacts are exact complementarity. By default friction is a box whose sides lie along the world's
axes. The manual's NSGS solver has Coulomb's law, and is given a small tolerance here. DART is
imported when a function of the other modules is called.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.abilities import (
    BuildsMechanisms,
    Fields,
    ModelReader,
    RunsFiles,
    SchemeOfCase,
)
from plumbob.engines.adapters.constrained import CONSTRAINED, constrained
from plumbob.engines.adapters.pendulum_errors import bob_errors
from plumbob.engines.method import Engine, Method, ModelError, Simulation
from plumbob.models.scene import (
    ON_PLANE,
    ONE_SMOOTH,
    SMOOTH,
    Case,
)

if TYPE_CHECKING:
    from plumbob.engines.mechanism import Mechanism
    from plumbob.engines.peer_model import Layout, PeerModel
    from plumbob.engines.stepper import State, Stepper

EULER_STEP = Scheme(EULER, "start", implicit_damping=True, implicit_spring=True)
CAPSULES = (  # scenes that distinguish contact models, and the shortest plans
    *("capsule-line/ca1", "capsule-line/heading-000", "capsule-line/heading-030"),
    *("capsule-line/heading-045", "capsule-line/frictionless", "capsule-hold/0.999"),
    *("capsule-hold/unloading", "capsule-coast", "capsule-turn/0.3", "capsule-turn/heading-*"),
    *("capsule-turn/light-slider", "capsule-turn/heavy-slider", "capsule-plan/heading-*"),
    *("capsule-plan/light-slider", "capsule-plan/heavy-slider"),
)
METHODS = (
    Method(
        "dart/default",
        EULER_STEP,
        1,
        # The two free bodies have predicted errors at most steps.
        systems=(*CAPSULES, "capsule-train/ten", "free-body/flip", "free-body/symmetric"),
        kinds=(ONE_SMOOTH, SMOOTH, ON_PLANE),
    ),
    Method(
        "dart/nsgs",
        EULER_STEP,
        1,
        settings={"tolerance": 1e-8},
        # With a heavy slider, the iterations take minutes.
        systems=(*CAPSULES, "!*/heavy-slider", "rod-impact"),
    ),
)


def scheme(case: Case, method: Method) -> Scheme:
    """The scheme of `method` on this case. If bodies touch or a loop is closed, no theory covers
    the scheme.

    A free body turns by the exponential of the new angular velocity, as in MuJoCo. DART has the
    angular velocity along the world's axes, which makes no difference to a step. The force of a
    motor is explicit."""
    if constrained(case):
        return CONSTRAINED
    if case.system.name == "servo":
        joint_part = case.problem.joint_part
        return replace(method.scheme, implicit_damping=joint_part, implicit_spring=False)
    return replace(method.scheme, implicit_spring=case.system.kind == ONE_SMOOTH)


def model_error(case: Case, method: Method, step: float) -> ModelError:
    """Bounds on the model's error of each observable, by reason. A bob has a moment of inertia
    where a point mass has none; other systems have no model error."""
    if case.system.family != "simple_pendulum":
        return {}
    return bob_errors(case.problem.started, case.scene.duration)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Returns the simulation of `case` by `method` at `step` [s]; raises Unsupported and
    ParameterError."""
    from plumbob.engines.adapters.dart.simulation import prepare

    return prepare(case, method, step)


def _read_fields(path: Path) -> Fields:
    """Returns the fields that DART's reader takes from a model file; raises NotRead."""
    from plumbob.engines.adapters.dart.user_model import model_fields

    return model_fields(path)


def _load_file(path: Path, layout: Layout, step: float) -> PeerModel:
    """Returns a model file in DART, to be stepped by `step` [s]; raises NotRead."""
    from plumbob.engines.adapters.dart.user_model import user_model

    return user_model(path, layout, step)


def _build_mechanism(mechanism: Mechanism, start: State, step: float) -> Stepper:
    """Returns the stepper of a mechanism at `step` [s]; raises Unsupported."""
    from plumbob.engines.adapters.dart.stepper import DartStepper

    return DartStepper(mechanism, start, step)


ENGINE = Engine(
    "dart",
    "dartpy",
    METHODS,
    prepare,
    model_error,
    optional=True,
    abilities=(
        SchemeOfCase(scheme),
        ModelReader(_read_fields),
        RunsFiles(_load_file),
        BuildsMechanisms(_build_mechanism, "dart/default"),
    ),
)
