"""The cone pendulum on a rotating platform: its scenes as data, its invariants, facts and
quantities."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.parameters import known
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.stability import StabilityTheory
from plumbob.analytic.systems.cone_pendulum import ConePendulum, HungBody, solid_cone
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.analytic.theory import ErrorTheory
from plumbob.models.cone_pendulum.answers import answers_over_time, over_angle
from plumbob.models.quantities import RADIAN, swing_quantities
from plumbob.models.scene import (
    ONE_SMOOTH,
    Case,
    Observable,
    Parameters,
    Quantity,
    Scene,
    System,
    make_scene,
    replaced,
    step_sizes,
)

if TYPE_CHECKING:
    from plumbob.analytic.sensitivities.neighbours import Neighbours, Sensitivity

SUDAKOV_2015 = (
    "V. F. Sudakov, Angular velocity of physical pendulum suspended on movable base, "
    "Herald of the Bauman MSTU, Instrum. Eng., 2015, no. 5, pp. 124-135, "
    "https://doi.org/10.18698/0236-3933-2015-5-124-135"
)
_CONE = ("density", "height", "apex_angle")
_BODY = ("mass", "com_distance", "inertia_x", "inertia_y", "inertia_z")
_PRODUCT = "inertia_yz"  # parameter that may be left out
_REST = ("pivot_x", "pivot_y", "platform_rate", "gravity", "theta", "theta_dot")
_MORE = ("excess", "pivot_z")  # parameters that may be left out
_STEEL: Parameters = MappingProxyType(
    {
        "density": 8000.0,
        "height": 0.3,
        "apex_angle": math.radians(30.0),
        "pivot_x": 0.0,
        "pivot_y": 0.09,
        "platform_rate": 26.0,
        "gravity": 9.8,
        "theta": 0.0,
        "theta_dot": 37.0,
    }
)
_PITCHFORK = 6.4482287920129893  # [rad/s] omega^2 = c / (I_x - I_z), for the steel cone


def problem(parameters: Parameters) -> ConePendulum:
    """Returns the cone pendulum that parameters describe; raises ParameterError."""
    is_general = "mass" in parameters
    shape_names = (*_BODY, _PRODUCT) if is_general else _CONE
    known(parameters, (*shape_names, *_REST, *_MORE))
    values = dict(parameters)
    shape = [values.pop(name) for name in shape_names if name in values or name != _PRODUCT]
    body = HungBody(*shape) if is_general else solid_cone(*shape)
    return ConePendulum(body=body, **values)


def change_cone(parameters: Parameters, changes: Parameters) -> Parameters:
    """Returns parameters with some values changed. If a parameter of a general body is changed, the
    parameters of such a body replace the cone's three. A change of theta_dot removes the excess of
    energy."""
    changes_body = not {*_BODY, _PRODUCT}.isdisjoint(changes)
    if changes_body and "mass" not in parameters:
        others = {name: parameters[name] for name in parameters if name not in _CONE}
        return {**_mass_properties(problem(parameters).body), **others, **changes}
    if "theta_dot" in changes and "excess" not in changes:
        parameters = {name: parameters[name] for name in parameters if name != "excess"}
    return replaced(parameters, changes)


def _mass_properties(body: HungBody) -> dict[str, float]:
    """Returns the parameters that describe a body of any shape."""
    return {name: getattr(body, name) for name in (*_BODY, _PRODUCT)}


def invariants(problem: ConePendulum, observed: Signals) -> Signals:
    """Returns the drift of the Jacobi integral [J], relative to the spread of the potential. A
    motion that repeats also has the drift of the action, relative to the action at the start: dI =
    dH/Omega, Sudakov 2015, eq. 12, to first order in dH."""
    motion = problem.motion
    inertia = problem.body.inertia_x
    rates = observed["theta_dot"]
    energy = inertia * motion.rotor.energy(observed["theta"] + problem.tilt, rates)
    drift = energy - energy[0]
    spread = max(motion.potential.scale, inertia * rates[0] ** 2 / 2)
    drifts = {"jacobi_integral": drift / spread}
    if motion.regime in ("libration", "rotation"):
        drifts["action"] = drift / (motion.mean_rate * motion.action)
    return drifts


def facts(problem: ConePendulum) -> Mapping[str, Any]:
    """Returns mass properties, barrier, equilibria, period and action; those of the printed
    Hamiltonian stand apart."""
    motion = problem.motion
    offset = problem.potential_offset
    barrier = None
    if motion.barriers.size:
        barrier = float(double(motion.barriers[0])) + offset
    printed_motion = problem.printed_motion()
    printed_barrier, printed_barrier_theta = problem.printed_barrier
    return {
        **_motion_facts(motion),
        "jacobi_integral": float(double(motion.energy)) + offset,
        "barrier": barrier,
        "body": _mass_properties(problem.body),
        "equilibria": [asdict(equilibrium) for equilibrium in problem.equilibria],
        "pitchfork_rate": problem.pitchfork_rate,
        "saddle_node_rate": problem.saddle_node_rate,
        "printed_hamiltonian": {
            **_motion_facts(printed_motion),
            "energy": float(double(printed_motion.energy)),
            "barrier": printed_barrier,
            "barrier_theta": printed_barrier_theta,
            "note": "eq. 9 as printed, T + U: not conserved; kept for the paper's figures alone",
        },
    }


def interest(case: Case) -> tuple[Quantity, ...]:
    """Returns the angle; its scale is the amplitude of a libration, otherwise one radian."""
    motion: PendulumMotion = case.problem.motion
    if motion.regime != "libration":
        return (Quantity("theta", RADIAN),)
    return swing_quantities(case, motion.period)


def _motion_facts(motion: PendulumMotion) -> Mapping[str, Any]:
    """Returns the facts on a motion."""
    return {
        "kind": motion.regime,
        "well": motion.well,
        "period": motion.period,
        "period_condition": motion.period_condition,
        "action": motion.action,
        "mean_rate": motion.mean_rate,
    }


def cone_stability(problem: ConePendulum) -> StabilityTheory:
    """Returns the theory of the largest steps on the motion."""
    from plumbob.analytic.errors.stability.pendulums import pendulum_stability

    motion = problem.motion
    theta, theta_dot = (float(part[0]) for part in motion.closed_form.state(np.zeros(1)))
    return pendulum_stability(
        motion.rotor, (theta, theta_dot), motion, motion.period, problem.tilt
    )


def errors(problem: ConePendulum) -> ErrorTheory:
    """Returns the theory of the errors of fixed steps on the motion."""
    from plumbob.analytic.errors.smooth_motion.rotor_errors import pendulum_errors

    return pendulum_errors(problem.motion)


def gradients(problems: Sequence[Neighbours[ConePendulum]], times: Array) -> list[Sensitivity]:
    """Returns the sensitivities at `times` [s], shape (n,), by each parameter; `problems` has the
    neighbours by one parameter each."""
    from plumbob.analytic.sensitivities.smooth_systems import cone_pendulum_gradients

    return cone_pendulum_gradients(problems, times)


_scene = partial(
    make_scene,
    system="cone-pendulum",
    steps=step_sizes(5e-3, 2.5e-6),
    base=_STEEL,
    source=SUDAKOV_2015,
    change=change_cone,
)


_level = partial(_scene, pivot_y=0.0, theta_dot=0.0)
_pitchfork = partial(
    _level,
    hard="quartic well: the period grows as 1/amplitude",
    platform_rate=_PITCHFORK,
    steps=step_sizes(2e-2, 2e-4),
)
_equal = partial(
    _level,
    hard="homoclinic to theta = 0: errors grow as e^(7.4 t)",
    platform_rate=10.0,
    theta=1e-3,
    steps=step_sizes(5e-3, 5e-5),
)


def _near_barrier(k: int, above: float, below: float) -> tuple[Scene, Scene]:
    """Returns the scenes whose energy is a relative 10^-k above and below the barrier, over two
    passages of the saddle. `above` and `below` are the rates theta_dot [rad/s] of the start."""

    def scene(side: str, theta_dot: float, profile: str) -> Scene:
        """Returns the scene on one side of the barrier."""
        return _scene(
            f"{side}-barrier-1e-{k}",
            f"energy {side} the barrier by 10^-{k} of it",
            1.5,
            hard=f"errors grow as e^(24.7 t) at the saddle; period grows as ln(10^{k})",
            theta_dot=theta_dot,
            profile=profile,
            steps=step_sizes(1e-3, 1e-5),
        )

    return (
        scene("above", above, "quick" if k == 6 else "full"),
        scene("below", below, "full"),
    )


def _barrier_scenes() -> tuple[Scene, ...]:
    """Returns the scenes near the barrier, for each k the one above it first."""
    scenes: list[Scene] = []
    for k, above, below in _RATES:
        scenes += _near_barrier(k, above, below)
    return tuple(scenes)


# For each k, the rates [rad/s] with which the energy is 10^-k above and below the barrier. A test
# computes them from the excess of energy. They are numbers here: listing scenes should not evaluate
# elliptic functions.
_RATES = (
    (3, 15.81226596825229, 15.801534486539067),
    (4, 15.807437703058957, 15.806364554948845),
    (5, 15.806954795425456, 15.806847480614508),
    (6, 15.80690650385069, 15.806895772369595),
    (7, 15.806901674685099, 15.80690060153699),
    (8, 15.806901191768459, 15.806901084453647),
    (9, 15.806901143476795, 15.806901132745313),
    (10, 15.806901138647627, 15.80690113757448),
    (11, 15.806901138164712, 15.806901138057396),
    (12, 15.80690113811642, 15.806901138105689),
)
SCENES = (
    _scene(
        "rotating-base",
        "the source's Fig. 3: rotation on a platform at 26 rad/s",
        0.5,
        profile="quick",
    ),
    _scene(
        "resting-base",
        "the source's Fig. 2: rotation on a platform at rest",
        1.0,
        profile="quick",
        platform_rate=0.0,
        theta_dot=13.0,
    ),
    _scene("deep-well", "libration in the deeper of two wells", 0.5, theta=1.5, theta_dot=5.0),
    _scene("shallow-well", "libration in the shallower well", 0.7, theta=-1.47, theta_dot=2.0),
    _scene("both-wells", "libration over both wells", 1.0, theta=-0.5, theta_dot=12.0),
    _scene(
        "unequal-inertia",
        "a body with I_y = I_x + 0.03: the printed I_x for I_y matters",
        0.5,
        inertia_y=solid_cone(8000.0, 0.3, math.radians(30.0)).inertia_y + 0.03,
        profile="quick",
    ),
    _scene(
        "product-of-inertia",
        "a body whose principal axes are tilted about the swing axis",
        0.5,
        inertia_yz=0.029,
    ),
    *_barrier_scenes(),
    _pitchfork(
        "pitchfork",
        "hanging at the rate where it stops being stable",
        20.0,
        theta=0.1,
        profile="quick",
    ),
    _pitchfork(
        "pitchfork-small",
        "hanging at the rate where it stops being stable, at half the amplitude: twice the period",
        40.0,
        theta=0.05,
    ),
    _equal("equal-wells", "beyond the pitchfork: from next to the saddle over both wells", 8.0),
    _equal(
        "equal-wells-short",
        "beyond the pitchfork: from next to the saddle until the first return",
        2.0,
        profile="quick",
    ),
    _scene(
        "flat-cone",
        "a cone so flat that I_x < I_z",
        1.0,
        hard="the centrifugal term changes sign",
        apex_angle=2 * math.atan(2.5),
        theta_dot=30.0,
    ),
    _scene(
        "fast-platform",
        "a platform at 1000 rad/s",
        0.05,
        hard="accelerations of 10^6 rad/s^2",
        platform_rate=1000.0,
        theta_dot=1500.0,
        steps=step_sizes(1e-4, 1e-7),
        profile="quick",
    ),
    _scene(
        "faster-platform",
        "a platform at 10^4 rad/s",
        0.005,
        hard="accelerations of 10^8 rad/s^2",
        platform_rate=1e4,
        theta_dot=1.5e4,
        steps=step_sizes(1e-5, 1e-8),
    ),
    _scene(
        "million-steps",
        "the source's Fig. 3, for 625 turns",
        100.0,
        hard="10^6 steps of 1e-4 s: energy bounded, or drifting at a rate",
        steps=(8e-4, 4e-4, 2e-4, 1e-4),
    ),
)

SYSTEMS = (
    System(
        name="cone-pendulum",
        rank=1,
        title="Cone pendulum on a rotating platform",
        observables=(Observable("theta", "rad"), Observable("theta_dot", "rad/s")),
        parameters=(*_CONE, *_BODY, _PRODUCT, *_REST, *_MORE),
        scenes=SCENES,
        default="rotating-base",
        problem=problem,
        reference=lambda problem: problem.reference,
        errors=errors,
        stability=cone_stability,
        start=("theta", "theta_dot"),
        invariants=invariants,
        facts=facts,
        model_module=f"{__name__}.model",
        mjcf=Path(__file__).parent / "cone_pendulum.xml",
        family="cone_pendulum",
        kind=ONE_SMOOTH,
        change=change_cone,
        interest=interest,
        sensitivity=gradients,
        also=answers_over_time,
        by_angle=over_angle,
    ),
)
