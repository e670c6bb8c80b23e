"""PyBullet as an engine: Bullet's multibodies in double precision, semi-implicit Euler; motors,
loops and contacts by sequential impulses.

By default every body's velocity is damped, and the solver stops after 50 iterations or at a
residual of 1e-7; the best that the manual allows has neither. A prescribed motion is a velocity
motor without a limit to its force. Every module but this one imports PyBullet.
"""

from __future__ import annotations

from types import MappingProxyType

from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.abilities import BuildsMechanisms, ModelReader, RunsFiles, SchemeOfCase
from plumbob.engines.adapters.constrained import CONSTRAINED, constrained
from plumbob.engines.adapters.pendulum_errors import model_error
from plumbob.engines.method import Engine, Method
from plumbob.models.scene import ON_PLANE, ONE_SMOOTH, SMOOTH, Case, later

EULER_STEP = Scheme(EULER, "start")
OTHERWISE = Scheme("euler with damping, motors or contacts")  # without a theory here
LINES = ("capsule-line/ca1", "capsule-line/heading-030")
DAMPED = (  # enough to show what the default damping does
    *("simple-pendulum/free-large", "cone-pendulum/rotating-base", "capsule-line/ca1"),
    *("capsule-line/heading-030", "capsule-coast/spin"),
)
OTHERS = (  # a representative of each system that is of no kind below
    *("capsule-coast", "capsule-turn/light-slider", "capsule-plan/heading-030"),
    *("capsule-hold/unloading", "capsule-train/ten", "free-body/flip", "free-body/symmetric"),
)
# A body that is held does not move by a bit at large steps, and at small ones it slides for the
# millisecond before shapes have their static penetration: such errors have no order.
HELD = ("!incline/rest", "!incline/just-held", "!pinch/0.*", "!pinch/lifted")
UNDAMPED = MappingProxyType(
    {"linearDamping": 0.0, "angularDamping": 0.0, "maxJointVelocity": 1e9}
)
ITERATED = MappingProxyType(
    {"numSolverIterations": 200, "solverResidualThreshold": 0.0, **UNDAMPED}
)
HARD = MappingProxyType(
    {
        # Shapes touch where they overlap, and not before. Bullet's default slop, 10 micrometres of
        # overlap that stay, is off, and so is the velocity that pushes overlapping shapes apart.
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


def scheme(case: Case, method: Method) -> Scheme:
    """The scheme of `method` on this case; none with a theory if bodies touch or a loop is closed.

    A free body turns by the exponential of the new angular velocity, as in MuJoCo."""
    return CONSTRAINED if constrained(case) else method.scheme


ENGINE = Engine(
    "pybullet",
    "pybullet",
    METHODS,
    later(f"{__name__}.simulation.prepare"),
    model_error,
    optional=True,
    abilities=(
        SchemeOfCase(scheme),
        ModelReader(later(f"{__name__}.user_model.model_fields")),
        RunsFiles(later(f"{__name__}.user_model.user_model")),
        BuildsMechanisms(later(f"{__name__}.simulation.built"), "pybullet/default"),
    ),
)
