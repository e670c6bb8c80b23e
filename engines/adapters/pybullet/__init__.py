"""PyBullet as an engine: Bullet's multibodies in double precision, stepped by semi-implicit Euler.
Motors, loops and contacts act by sequential impulses.

By default Bullet damps the velocity of every body, and its solver stops after 50 iterations or at a
residual of 1e-7. The most accurate settings of the manual have no damping and more iterations. A
velocity motor with an unlimited force prescribes the motion of a joint. All modules of this folder
but this one import PyBullet.
"""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.abilities import (
    BuildsMechanisms,
    Fields,
    ModelReader,
    RunsFiles,
    SchemeOfCase,
)
from plumbob.engines.adapters.constrained import scheme_unless_constrained
from plumbob.engines.adapters.pendulum_errors import model_error
from plumbob.engines.adapters.stepped_mechanism import simulated
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.models.scene import ON_PLANE, ONE_SMOOTH, SMOOTH, Case

if TYPE_CHECKING:
    from plumbob.engines.mechanism import Mechanism
    from plumbob.engines.peer_model import Layout, PeerModel
    from plumbob.engines.stepper import State, Stepper

# A free body turns by the exponential of the new angular velocity, as in MuJoCo.
EULER_STEP = Scheme(EULER, "start")
# A scheme that no theory here covers
OTHERWISE = Scheme("euler with damping, motors or contacts")
LINES = ("capsule-line/ca1", "capsule-line/heading-030")
DAMPED = (  # scenes that show the effect of the default damping
    *("simple-pendulum/free-large", "cone-pendulum/rotating-base", "capsule-line/ca1"),
    *("capsule-line/heading-030", "capsule-coast/spin"),
)
OTHERS = (  # one scene of each system that is of none of the kinds below
    *("capsule-coast", "capsule-turn/light-slider", "capsule-plan/heading-030"),
    *("capsule-hold/unloading", "capsule-train/ten", "free-body/flip", "free-body/symmetric"),
)
# At large steps, a body that friction holds does not move at all. At small steps, it slides for a
# millisecond, until the shapes have their static penetration. Such errors have no order.
HELD = ("!incline/rest", "!incline/just-held", "!pinch/0.*", "!pinch/lifted")
UNDAMPED = MappingProxyType(
    {"linearDamping": 0.0, "angularDamping": 0.0, "maxJointVelocity": 1e9}
)
ITERATED = MappingProxyType(
    {"numSolverIterations": 200, "solverResidualThreshold": 0.0, **UNDAMPED}
)
HARD = MappingProxyType(
    {
        # Contacts act only between shapes that overlap. Two defaults are off: the slop, which is an
        # overlap of 10 micrometres that Bullet does not correct, and the velocity that pushes
        # overlapping shapes apart.
        "contactBreakingThreshold": 1e-12,  # [m]
        "contactSlop": 0.0,  # [m]
        "contactERP": 0.0,
    }
)
METHODS = (
    Method("pybullet/default", OTHERWISE, 1, systems=DAMPED),
    Method(
        "pybullet/undamped+iterated",
        EULER_STEP,
        1,
        settings=ITERATED,
        systems=(*LINES, *OTHERS, *HELD),
        kinds=(ONE_SMOOTH, SMOOTH, ON_PLANE),
    ),
    Method(
        "pybullet/undamped+hard",
        EULER_STEP,
        1,
        settings={**ITERATED, **HARD},
        systems=("capsule-line/heading-030",),
        kinds=(ON_PLANE,),
    ),
    Method(
        "pybullet/undamped+pyramid",
        OTHERWISE,
        1,
        settings={**ITERATED, "enableConeFriction": 0},
        systems=("capsule-line/heading-030",),
    ),
)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Returns the simulation of `case` by `method` at `step` [s]; raises Unsupported and
    ParameterError."""
    from plumbob.engines.adapters.pybullet.client import error_of_pybullet
    from plumbob.engines.adapters.pybullet.stepper import BulletStepper

    def build(mechanism: Mechanism, start: State) -> Stepper:
        """The stepper of a mechanism with the method's settings."""
        return BulletStepper(mechanism, method.settings, step)

    broken = (OverflowError, ValueError, error_of_pybullet())
    return simulated(case, step, build, broken)


def _read_fields(path: Path) -> Fields:
    """Returns the fields that Bullet's reader takes from a model file; raises NotRead."""
    from plumbob.engines.adapters.pybullet.user_model import model_fields

    return model_fields(path)


def _load_file(path: Path, layout: Layout, step: float) -> PeerModel:
    """Returns a model file in Bullet, to be stepped by `step` [s]; raises NotRead."""
    from plumbob.engines.adapters.pybullet.user_model import user_model

    return user_model(path, layout, step)


def _build_mechanism(mechanism: Mechanism, start: State, step: float) -> Stepper:
    """Returns the stepper of a mechanism at `step` [s] with Bullet's default settings, but without
    the damping that Bullet gives the velocities of all bodies by default; raises Unsupported."""
    from plumbob.engines.adapters.pybullet.stepper import BulletStepper

    return BulletStepper(mechanism, UNDAMPED, step)


ENGINE = Engine(
    "pybullet",
    "pybullet",
    METHODS,
    prepare,
    model_error,
    optional=True,
    abilities=(
        SchemeOfCase(scheme_unless_constrained),
        ModelReader(_read_fields),
        RunsFiles(_load_file),
        BuildsMechanisms(_build_mechanism, "pybullet/default"),
    ),
)
