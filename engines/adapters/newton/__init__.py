"""Newton as an engine, with three of Newton's solvers: Featherstone's algorithm for trees, XPBD for
contacts and loops, and MuJoCo Warp. They compute in single precision, on the processor or the GPU
that Warp chooses.

Newton compiles its kernels when they are first called. All modules of this folder but this one
import Newton.
"""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from plumbob.analytic.schemes import EULER, Scheme
from plumbob.engines.abilities import Fields, ModelReader, RunsFiles, SchemeOfCase
from plumbob.engines.adapters.constrained import CONSTRAINED, scheme_unless_constrained
from plumbob.engines.adapters.mjwarp import start_warp
from plumbob.engines.adapters.pendulum_errors import model_error
from plumbob.engines.adapters.ported import SINGLE
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.models.scene import Case

if TYPE_CHECKING:
    from plumbob.engines.peer_model import Layout, PeerModel

STEP = Scheme(EULER, "start", tangent_turn=True, unit=SINGLE)
MUJOCO_STEP = Scheme(EULER, "start", implicit_damping=True, unit=SINGLE)
# Scenes close to a barrier, and scenes with stiff modes, are left out: no theory here covers the
# rounding of single precision in them.
PENDULUMS = (
    *("simple-pendulum/free-large", "simple-pendulum/damped-*", "simple-pendulum/forced-large"),
    *("linear-pendulum/forced-large", "linear-pendulum/overdamped"),
    *("cone-pendulum/rotating-base", "servo/joint-damped", "servo/motor-damped"),
    "servo/held-half",
)
TREES = ("projectile", "n-pendulum", "heavy-top", "free-body")
TOUCHING = (
    *("incline/stops", "pinch/0.5", "rolling-ball/slide-to-roll", "rolling-disc/wobbling"),
    *("stack/equal", "capsule-coast/translation", "capsule-hold/0.999"),
    *("capsule-line/heading-030", "capsule-train/ten", "capsule-turn/0.3"),
    "capsule-plan/near-free",
)
BOUNCING = ("bouncing-ball/half", "rod-impact/sticks")
LOOPS = ("four-bar/crank-rocker", "slider-crank/turning")
# Scenes for MuJoCo Warp: one scene for each setting in which Newton's defaults differ from
# MuJoCo's.
DEFAULTS = (
    *("linear-pendulum/overdamped", "servo/motor-damped", "pinch/0.5", "bouncing-ball/plastic"),
)
XPBD = MappingProxyType({"solver": "xpbd"})
METHODS = (
    Method(
        "newton/featherstone",
        STEP,
        1,
        settings={"solver": "featherstone", "angular_damping": 0.0},
        systems=(*PENDULUMS, *TREES),
    ),
    Method(
        "newton/xpbd",
        CONSTRAINED,
        1,
        settings=XPBD,
        systems=(*TOUCHING, *BOUNCING, *LOOPS, "n-pendulum/triple"),
    ),
    # By default XPBD scales the forces and the moments of joints by two different factors.
    Method(
        "newton/xpbd+iterated",
        CONSTRAINED,
        1,
        settings={
            **XPBD,
            "iterations": 50,
            "joint_linear_relaxation": 0.5,
            "joint_angular_relaxation": 0.5,
        },
        systems=("four-bar/crank-rocker", "n-pendulum/triple"),
    ),
    Method(
        "newton/mujoco",
        MUJOCO_STEP,
        1,
        settings={"solver": "mujoco"},
        systems=(*DEFAULTS, *LOOPS),
    ),
)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """The simulation of a case by a method at `step` [s]; raises Unsupported and ParameterError."""
    start_warp()
    from plumbob.engines.adapters.newton import simulation

    return simulation.prepare(case, method, step)


def _read_fields(path: Path) -> Fields:
    """Returns the fields that Newton's reader takes from a model file; raises NotRead."""
    from plumbob.engines.adapters.newton.user_model import model_fields

    return model_fields(path)


def _load_file(path: Path, layout: Layout, step: float) -> PeerModel:
    """Returns a model file in Newton, to be stepped by `step` [s]; raises NotRead."""
    from plumbob.engines.adapters.newton.user_model import user_model

    return user_model(path, layout, step)


ENGINE = Engine(
    "newton",
    "newton",
    METHODS,
    prepare,
    model_error,
    optional=True,
    abilities=(
        SchemeOfCase(scheme_unless_constrained),
        ModelReader(_read_fields),
        RunsFiles(_load_file, 2.0**-24),
    ),
)
