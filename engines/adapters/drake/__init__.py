"""Drake as an engine: its discrete multibody plant with each of Drake's contact solvers, and its
continuous plant with Drake's error-controlled integrators.

The simulator steps in C++: the forces of actuators come from a source in the same diagram. The
motion of a joint is prescribed by a rotor with so large an inertia that no load changes its motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.analytic.schemes import ADAPTIVE, EULER, Scheme
from plumbob.engines.abilities import (
    BuildsMechanisms,
    Fields,
    ModelReader,
    RunsFiles,
    SchemeOfCase,
    SecondRun,
)
from plumbob.engines.adapters.constrained import CONSTRAINED, constrained
from plumbob.engines.adapters.own_derivatives import derivative_by_mechanisms
from plumbob.engines.adapters.pendulum_errors import model_error_on_platform
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.models.scene import (
    ON_PLANE,
    ONE_SMOOTH,
    SMOOTH,
    Case,
)

if TYPE_CHECKING:
    from plumbob.engines.mechanism import Mechanism
    from plumbob.engines.peer_model import Layout, PeerModel
    from plumbob.engines.stepper import EndDerivatives, SceneMechanism, State, Stepper

EULER_STEP = Scheme(EULER, "start", implicit_damping=True, tangent_turn=True)
TOLERANCES = tuple(float(f"1e-{digits}") for digits in range(3, 8))
RK3 = "runge_kutta3"
SMALLEST = 1e-9  # smallest accuracy of the integrators
SOLVERS = ("capsule-line/heading-030",)  # scene that distinguishes the contact solvers
# One scene of each system that is of none of the kinds of `_discrete`, and the free bodies whose
# errors are predicted.
OTHERS = (
    *("free-body/flip", "free-body/symmetric", "capsule-plan/heading-030"),
    *("capsule-turn/0.3", "capsule-train/ten"),
)
LINE_AND_COAST = (
    *SOLVERS,
    "capsule-coast/spin",
    "capsule-coast/edge",
    "capsule-hold/unloading",
)


def _discrete(
    name: str, approximation: str | None, systems: tuple[str, ...] = (), **settings: Any
) -> Method:
    """A method in the discrete plant with a contact `approximation`, Drake's default if None, and
    further settings. Without `systems` it is run on all systems that Drake builds."""
    solver = {"discrete_contact_approximation": approximation} if approximation else {}
    kinds = () if systems else (ONE_SMOOTH, SMOOTH, ON_PLANE)
    return Method(
        f"drake/{name}",
        EULER_STEP,
        1,
        settings={**solver, **settings},
        systems=systems or (*LINE_AND_COAST, *OTHERS),
        kinds=kinds,
    )


def _adaptive(name: str, scheme: str, *systems: str) -> Method:
    """A method in the continuous plant with an integrator that controls its error, run on two
    pendulums and on these systems."""
    return Method(
        f"drake/{name}",
        Scheme(ADAPTIVE),
        order=None,
        control="tolerance",
        settings={"integration_scheme": scheme},
        step_sizes=TOLERANCES,
        systems=("simple-pendulum/free-large", "cone-pendulum/rotating-base", *systems),
    )


METHODS = (
    _discrete("default", None),
    _discrete("tamsi", "tamsi", SOLVERS),
    _discrete("sap", "sap", SOLVERS),
    _discrete("similar", "similar", SOLVERS),
    _discrete("tamsi+stiction", "tamsi", LINE_AND_COAST, stiction_tolerance=1e-7),
    _discrete("lagged+stiction", "lagged", SOLVERS, stiction_tolerance=1e-7),
    _adaptive("rk3", RK3),
    _adaptive("cenic", "cenic", *SOLVERS, "capsule-coast/spin"),
)


def scheme(case: Case, method: Method) -> Scheme:
    """The scheme of `method` on this case. If bodies touch or a loop is closed, no theory covers
    the scheme.

    A step moves a quaternion along its tangent, which turns a free body by 2 atan(w h/2) about the
    new angular velocity w. The force of a motor is explicit."""
    system = case.system
    if constrained(case):
        return CONSTRAINED
    if system.name == "servo":
        return replace(method.scheme, implicit_damping=case.problem.joint_part)
    return method.scheme


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """The simulation of a case by a method at `step` [s], or at the accuracy `step` if the method
    controls its error; raises Unsupported and ParameterError."""
    from plumbob.engines.adapters.drake import scenes

    if method.control == "tolerance":
        return scenes.continuous(case, method, step, SMALLEST)
    return scenes.discrete(case, method, step)


def confirming(method: Method) -> tuple[Method, float]:
    """The method and the accuracy of a second run that confirms a first: the explicit integrator at
    its smallest accuracy, on the same equations."""
    return replace(method, settings={"integration_scheme": RK3}), SMALLEST


def _read_fields(path: Path) -> Fields:
    """Returns the fields that Drake's reader takes from a model file; raises NotRead."""
    from plumbob.engines.adapters.drake.user_model import model_fields

    return model_fields(path)


def _load_file(path: Path, layout: Layout, step: float) -> PeerModel:
    """Returns a model file in Drake, to be stepped by `step` [s]; raises NotRead."""
    from plumbob.engines.adapters.drake.user_model import user_model

    return user_model(path, layout, step)


def _build_mechanism(mechanism: Mechanism, start: State, step: float) -> Stepper:
    """Returns the stepper of a mechanism in Drake's discrete plant, with Drake's default settings,
    at `step` [s]; raises Unsupported."""
    from plumbob.engines.adapters.drake.stepper import DrakeStepper

    return DrakeStepper(mechanism, {"time_step": step}, step)


def _derivatives(
    scenes: Sequence[SceneMechanism],
    distance: float,
    method: Method,
    step: float,
    duration: float,
) -> EndDerivatives:
    """Returns the derivatives of the end of a run of `duration` [s], see
    `OwnDerivative.of_mechanisms`; raises Unsupported."""
    from plumbob.engines.adapters.drake.autodiff import derivatives

    return derivatives(scenes, distance, method, step, duration)


ENGINE = Engine(
    "drake",
    "pydrake",
    METHODS,
    prepare,
    model_error_on_platform,
    optional=True,
    abilities=(
        SchemeOfCase(scheme),
        SecondRun(confirming),
        ModelReader(_read_fields),
        RunsFiles(_load_file),
        BuildsMechanisms(_build_mechanism, "drake/default"),
        derivative_by_mechanisms("autodiff", _derivatives, 1e-12),
    ),
)
