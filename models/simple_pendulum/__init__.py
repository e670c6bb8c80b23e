"""The simple pendulum and the linear pendulum: their scenes as data, their invariants, facts and
quantities."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.parameters import ParameterError, finite, known, positive
from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.stability import StabilityTheory
from plumbob.analytic.systems.pendulums.rod_tension import BOB_MASS
from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.analytic.theory import ErrorTheory
from plumbob.models.quantities import swing_quantities
from plumbob.models.scene import (
    ONE_SMOOTH,
    Observable,
    Parameters,
    Scene,
    System,
    make_scene,
    replaced,
    step_sizes,
)

if TYPE_CHECKING:
    from plumbob.analytic.sensitivities.neighbours import Neighbours, Sensitivity

NOTEBOOK_SOURCE = (
    "Pêndulo Simples, course notebook: the simple pendulum, linear and non-linear, free, damped "
    "and forced, by RK4"
)
FROM_TOP = "theta_from_top"  # parameter that replaces theta
# {parameter in the notebook's form: parameter that it replaces}: C [kg/s], and F_0 [N] of the force
# F(t) = F_0 sin(Omega t)
OWN_FORM = MappingProxyType({"damping": "damping_rate", "force": "forcing_amplitude"})
_REST: Parameters = MappingProxyType(
    {
        "length": 1.0,
        "gravity": 9.8,
        "damping_rate": 0.0,
        "forcing_amplitude": 0.0,
        "forcing_frequency": 0.0,
        "theta": 0.0,
        "theta_dot": 0.0,
    }
)
PARAMETERS = (*_REST, "mass", "damping", "force")
_DEGREE = math.pi / 180


def problem(parameters: Parameters, linear: bool = False) -> SimplePendulum:
    """Returns the pendulum that parameters describe; raises ParameterError."""
    known(parameters, PARAMETERS if linear else (*PARAMETERS, FROM_TOP))
    if FROM_TOP in parameters:
        from_top = parameters[FROM_TOP]
        finite(FROM_TOP, from_top)
        if "theta" in parameters:
            raise ParameterError(FROM_TOP, from_top, "left out where theta is given")
        # Here theta selects the turn that theta_from_top is measured from.
        parameters = {**parameters, "theta": math.pi}
    return SimplePendulum(**per_unit_mass(parameters), linear=linear)


def per_unit_mass(parameters: Parameters) -> dict[str, Any]:
    """Returns parameters with xi = C/m and A = F_0/(m L) in place of C and F_0; raises
    ParameterError if both forms are given."""
    values = dict(parameters)
    for name, rate in OWN_FORM.items():
        if name not in values:
            continue
        value = finite(name, values.pop(name))
        if rate in values:
            raise ParameterError(name, value, f"left out where {rate} is given")
        inertia = positive("mass", values.get("mass", BOB_MASS))
        if name == "force":
            inertia *= positive("length", values["length"])
        values[rate] = value / inertia
    return values


def change_pendulum(parameters: Parameters, changes: Parameters) -> Parameters:
    """Returns parameters with some values changed. A change of theta_from_top replaces theta, and
    the reverse. In the same way C and its rate, and F_0 and its amplitude, replace each other."""
    for pair in (*OWN_FORM.items(), ("theta", FROM_TOP)):
        changed_names = set(pair).intersection(changes)
        if changed_names:
            replaced_names = set(pair) - changed_names
            parameters = {n: v for n, v in parameters.items() if n not in replaced_names}
    return replaced(parameters, changes)


def invariants(problem: SimplePendulum, observed: Signals) -> Signals:
    """Returns the drift of the energy, relative to the energy needed to reach the top; empty if the
    energy is not conserved."""
    rotor = problem.rotor
    if not rotor.conservative:
        return {}
    energy = rotor.energy(observed["theta"], observed["theta_dot"])
    start = problem.started
    span = max(2 * rotor.sin, abs(float(rotor.energy(start.theta, start.theta_dot))))
    return {"energy": (energy - energy[0]) / (span or 1.0)}


def stability(problem: SimplePendulum) -> StabilityTheory:
    """Returns the theory of the largest steps on the motion."""
    from plumbob.analytic.errors.stability.pendulums import pendulum_stability

    start = problem.started
    elliptic = problem.elliptic
    period = math.inf if elliptic is None else elliptic.period
    state = start.theta, start.theta_dot
    return pendulum_stability(problem.rotor, state, problem.motion, period)


def errors(problem: SimplePendulum) -> ErrorTheory:
    """Returns the theory of the errors of fixed steps on the motion of a problem."""
    from plumbob.analytic.errors.smooth_motion.rotor_errors import simple_pendulum_errors

    return simple_pendulum_errors(problem)


def gradients(
    problems: Sequence[Neighbours[SimplePendulum]], times: Array
) -> list[Sensitivity]:
    """Returns the sensitivities at `times` [s], shape (n,), by each parameter; `problems` has the
    neighbours by one parameter each."""
    from plumbob.analytic.sensitivities.smooth_systems import simple_pendulum_gradients

    return simple_pendulum_gradients(problems, times)


def facts(problem: SimplePendulum) -> Mapping[str, Any]:
    """Returns the kind of motion, the natural frequency [rad/s] and the damping ratio. An undamped
    motion also has period [s], action and barrier."""
    natural = math.sqrt(problem.gravity / problem.length)
    facts: dict[str, Any] = {
        "kind": _kind(problem),
        "natural_frequency": natural,
        "damping_ratio": problem.damping_rate / (2 * natural) if natural else None,
    }
    motion = problem.elliptic
    if motion is not None:
        barrier = None
        if motion.barriers.size:
            barrier = problem.mass * float(double(motion.barriers[0]))
        facts |= {
            "period": motion.period,
            "period_condition": motion.period_condition,
            "action": problem.mass * motion.action,
            "mean_rate": motion.mean_rate,
            "energy": problem.mass * float(double(motion.energy)),
            "barrier": barrier,
        }
    elif problem.linear and problem.rotor.conservative and natural:
        facts["period"] = 2 * math.pi / natural
    return facts


def _kind(problem: SimplePendulum) -> str:
    """Returns the kind of motion in words."""
    if problem.elliptic is not None:
        return problem.elliptic.regime
    damping = problem.damping_rate
    critical = 2 * math.sqrt(problem.gravity / problem.length)
    words = ["forced"] if problem.forcing_amplitude else []
    if damping:
        words.append("overdamped" if damping > critical else "damped")
    return ", ".join(words) or "oscillation"


_scene = partial(
    make_scene,
    duration=50.0,
    steps=step_sizes(1e-1, 1e-5),  # includes the notebook's 0.05 s
    base=_REST,
    source=NOTEBOOK_SOURCE,
    change=change_pendulum,
)


def _scene_pair(
    case: str,
    summary: str,
    linear: str,
    linear_profile: str = "full",
    profile: str = "full",
    hard: str = "",
    **values: Any,
) -> tuple[Scene, Scene]:
    """Returns a scene of the simple pendulum, and a scene of the linear pendulum with the same
    start."""
    fewer = {"steps": step_sizes(1e-1, 1e-4), **values}
    return (
        _scene(case, summary, system="simple-pendulum", profile=profile, hard=hard, **values),
        _scene(case, linear, system="linear-pendulum", profile=linear_profile, **fewer),
    )


def _near_top(k: int) -> Scene:
    """Returns the scene that starts from rest 10^-k rad off the top."""
    return _scene(
        f"near-top-1e-{k}",
        f"from rest 10^-{k} off the top, through the bottom and up the other side",
        system="simple-pendulum",
        duration=float(math.ceil(0.75 * k + 1.5)),
        steps=step_sizes(2e-2, 2e-4),
        profile="quick" if k == 6 else "full",
        hard=f"errors grow as e^(3.13 t) at the top; period grows as ln(10^{k}); a double of theta "
        "holds the distance to 4e-16 rad",
        theta_from_top=-float(f"1e-{k}"),
    )


_LARGE = -120 * _DEGREE
# gains of a critically damped servo [1/s^2, 1/s], and the rate of the sine that it follows [rad/s]
_KP, _KV, _SLOW = 1e6, 2e3, 2.0
# complex amplitude of the steady motion: theta = Im(amplitude e^(i Omega t)) [rad]
_FOLLOWED = _KP / complex(_KP - _SLOW**2, _KV * _SLOW)
_SPIN = "an error of the speed becomes one of the angle that grows with time"
_SCENES = (
    *_scene_pair(
        "free-small",
        "case 1: a small swing",
        "case 1, linear: hardly different",
        theta=-10 * _DEGREE,
        profile="quick",
    ),
    *_scene_pair(
        "free-large",
        "case 2: a large swing",
        "case 2, linear: the wrong period",
        theta=_LARGE,
        profile="quick",
    ),
    *_scene_pair(
        "rotating-slow",
        "case 3: over the top, 11.5 % faster than it takes",
        "case 3, linear: swings where the pendulum rotates",
        theta=_LARGE,
        theta_dot=200 * _DEGREE,
        profile="quick",
        hard=f"near the separatrix: {_SPIN}",
    ),
    *_scene_pair(
        "rotating-fast",
        "case 4: rotates fast",
        "case 4, linear: swings by 200 degrees",
        theta=_LARGE,
        theta_dot=500 * _DEGREE,
        hard=f"73 turns: {_SPIN}",
    ),
    *_scene_pair(
        "damped-small",
        "case 5: a small swing dies away",
        "case 5, linear: hardly different",
        theta=-10 * _DEGREE,
        damping_rate=0.08,
    ),
    *_scene_pair(
        "damped-large",
        "case 6: a large swing dies away",
        "case 6, linear",
        theta=_LARGE,
        damping_rate=0.08,
    ),
    *_scene_pair(
        "damped-rotating",
        "case 7: turns over, is caught, and settles",
        "case 7, linear",
        theta=_LARGE,
        theta_dot=500 * _DEGREE,
        damping_rate=0.2,
        profile="quick",
        hard="passes the separatrix: how near decides when it is caught",
    ),
    *_scene_pair(
        "forced-small",
        "pushed gently near resonance, from rest",
        "pushed gently near resonance, linear",
        forcing_amplitude=0.1,
        forcing_frequency=3.0,
        damping_rate=0.08,
    ),
    *_scene_pair(
        "forced-large",
        "pushed hard near resonance, from rest",
        "pushed hard near resonance, linear",
        forcing_amplitude=1.5,
        forcing_frequency=2.8,
        damping_rate=0.2,
        profile="quick",
    ),
    *_scene_pair(
        "forced-chaotic",
        "pushed slowly and hard, g = L: chaos, followed for 50 s, well within "
        "the 156 s for which double precision tells its future to 1e-6 rad",
        "pushed slowly and hard, linear: no chaos",
        gravity=1.0,
        theta=0.2,
        damping_rate=0.5,
        forcing_amplitude=1.5,
        forcing_frequency=2 / 3,
        hard="neighbouring motions part as e^(0.12 t); the exact answer is known to 2e-12 rad",
    ),
    _scene(
        "million-steps",
        "the large swing of case 2, for 181 periods",
        system="simple-pendulum",
        theta=_LARGE,
        duration=500.0,
        steps=(8e-3, 4e-3, 2e-3, 1e-3, 5e-4),
        hard="10^6 steps of 5e-4 s: energy bounded, or drifting at a rate",
    ),
    *(_near_top(k) for k in range(1, 13)),
    *_scene_pair(
        "overdamped",
        "damped at 10/s, more than 2 sqrt(g/L): returns without a swing",
        "damped at 10/s, more than critically, linear",
        duration=10.0,
        steps=step_sizes(5e-2, 1e-4),
        theta=_LARGE,
        damping_rate=10.0,
        linear_profile="quick",
        hard="rates of 1.1/s and 8.9/s side by side",
    ),
    _scene(
        "overdamped-1e4",
        "damped at 10^4/s: the speed is lost within 1 ms, the angle within an hour",
        system="linear-pendulum",
        theta=_LARGE,
        theta_dot=500 * _DEGREE,
        damping_rate=1e4,
        duration=0.1,
        steps=step_sizes(5e-5, 5e-7),
        hard="rates of 10^4/s and 10^-3/s side by side: a ratio of 10^7",
    ),
    _scene(
        "stiff-spring",
        "a spring of 10^6/s^2 in place of gravity, undamped",
        system="linear-pendulum",
        gravity=1e6,
        theta=0.1,
        duration=1.0,
        steps=step_sizes(1e-3, 1e-6),
        hard="omega = 1000 rad/s: an explicit step of 2 ms or more diverges",
    ),
    _scene(
        "stiff-servo",
        "a servo of k_p = 10^6/s^2 and k_v = 2000/s, no armature, on the course of a slow sine",
        system="linear-pendulum",
        gravity=_KP,
        damping_rate=_KV,
        forcing_amplitude=_KP,
        forcing_frequency=_SLOW,
        theta=_FOLLOWED.imag,
        theta_dot=_SLOW * _FOLLOWED.real,
        duration=3.0,
        steps=step_sizes(2e-4, 2e-6),
        hard="omega = 1000 rad/s under a motion of 2 rad/s: a ratio of 500",
    ),
    *_scene_pair(
        "step-too-large",
        "the large swing, from steps far beyond what any method takes",
        "linear: unstable above 2 sqrt(L/g) = 0.64 s, RK4 above 0.90 s",
        theta=_LARGE,
        duration=20.0,
        steps=(2.0, 1.0, 0.7, 0.5, *step_sizes(2e-1, 1e-3)),
        hard="divergence",
    ),
)


def _system(name: str, title: str, observables: tuple[Observable, ...], linear: bool) -> System:
    """Returns the system of the simple or the linear pendulum."""
    return System(
        name=name,
        rank=9 if linear else 8,
        title=title,
        observables=observables,
        parameters=PARAMETERS if linear else (*PARAMETERS, FROM_TOP),
        scenes=tuple(scene for scene in _SCENES if scene.system == name),
        default="free-large",
        problem=partial(problem, linear=linear),
        reference=lambda problem: problem.motion,
        errors=errors,
        stability=stability,
        start=("theta", "theta_dot"),
        invariants=invariants,
        facts=facts,
        model_module=f"{__name__}.model",
        mjcf=Path(__file__).parent / "simple_pendulum.xml",
        family="simple_pendulum",
        kind=ONE_SMOOTH,
        change=change_pendulum,
        interest=swing_quantities,
        sensitivity=gradients,
        left_out={"mass": BOB_MASS},
    )


_MOTION = (Observable("theta", "rad"), Observable("theta_dot", "rad/s"))
SYSTEMS = (
    _system(
        "simple-pendulum", "Simple pendulum", (*_MOTION, Observable("tension", "N")), False
    ),
    _system("linear-pendulum", "Linear pendulum", _MOTION, True),
)
