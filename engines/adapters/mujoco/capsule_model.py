"""The capsule's model file with a problem's numbers in it: body, supports, contacts, slider."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.errors.plane_steps import EULER, FRICTION_LEADS, RK4
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.analytic.systems.manoeuvres.residual_motion import ResidualMotion
from plumbob.analytic.systems.slider_path import SliderPath
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.contact_profiles import (
    GRIP,
    IMPEDANCE,
    ContactProfile,
    PairFields,
    convergent,
    coulomb_pair,
    profile,
)
from plumbob.engines.adapters.mujoco.translation import read

HOLD = 1e10  # least ratio of the slider's armature to its mass: its acceleration is off by 1/HOLD
POINT = 1e-14  # [kg m^2] of the slider about itself: MuJoCo wants more than 1e-15
SOFTER = 1e8  # times as soft against slip: the 1e2 of lines lets turns of epsilon 0.03 hop
PLACES = 2001  # of the slider on its way, for the largest of a smooth function of them
TURNING = "turning.xml"  # two sliding joints for the slider, along the axes of the body
PAIR = ("solimp", "solref", "solreffriction")
OPTIONS = ("cone", "impratio", "noslip_iterations", "tolerance", "noslip_tolerance")


def whole(
    mjcf: Path,
    problem: CapsuleProblem,
    settings: Mapping[str, Any] | None = None,
    step: float = 1e-4,
) -> mujoco.MjSpec:
    """The model in the file `mjcf`, or beside it in TURNING where the slider leaves its line, with
    the numbers of `problem`, what is only seen included, and the contacts that `settings` name at
    `step` [s]: those that converge unless it says otherwise.

    The height of C and of the slider above the plane is `settings["height"]` [m]; zero, as in the
    source, unless given.
    """
    given = settings or {"contact": "coulomb"}
    setup, height = problem.setup, float(given.get("height", 0.0))
    spec = read(mjcf if setup.plane_velocity is None else mjcf.with_name(TURNING))
    capsule, body = setup.capsule, spec.body("body")
    spec.option.gravity = gravity(setup)
    across = tilt_inertia(problem)
    body.pos = [0.0, 0.0, height]
    body.mass, body.inertia = capsule.body_mass, [across, across, capsule.inertia]
    for i, (x, y) in enumerate(capsule.supports):
        support = spec.geom(f"support_{i + 1}")
        support.pos = [x, y, support.size[0] - height]
    set_contacts(spec, contacts(problem, given), capsule.friction, step)
    spec.body("slider").pos = [*setup.slider, 0.0]
    set_slider(spec, setup, (math.cos(setup.direction), math.sin(setup.direction)))
    spec.body("slider").inertia = [POINT] * 3
    for key in tuple(spec.keys):  # the start is where the body rests, which is found by settling
        spec.delete(key)
    return spec


def set_slider(spec: mujoco.MjSpec, setup: CapsuleSetup, axis: tuple[float, float]) -> None:
    """Give the slider its mass, and the joint on its `axis`, or the two of the plane, the armature
    that imposes its motion; without a motion to impose the slider is fixed in the body.

    The solver's tolerance goes with the armature: termination is scaled by the trace of the mass
    matrix, which the armature inflates, and what is meant to be 1e-8 would be 1e2.
    """
    capsule, in_plane = setup.capsule, setup.plane_velocity is not None
    spec.body("slider").mass = capsule.slider_mass
    names = ("slider_x", "slider_y") if in_plane else ("slider",)
    if setup.relative_velocity is None and not in_plane:
        spec.delete(spec.actuator("slider"))
        spec.delete(spec.joint("slider"))
        return
    hold = armature(setup)
    if not in_plane:
        spec.joint("slider").axis = [*axis, 0.0]
    for name in names:
        spec.joint(name).armature = spec.actuator(name).gear[0] = hold
    scale = (capsule.body_mass + capsule.slider_mass) / hold
    spec.option.tolerance *= scale
    spec.option.noslip_tolerance *= scale


def contacts(problem: CapsuleProblem, settings: Mapping[str, Any]) -> ContactProfile:
    """The profile that `settings` name, and where it is one that converges and the motion one of
    the plane, made softer still: what slip does to a normal force goes as slip speed over step.

    There friction also asks for rest within half a step of RK4, whose stages it is late by that.
    """
    chosen = profile(settings)
    if not (convergent(settings) and off_line(problem)):
        return chosen
    options = {**chosen.options, "impratio": GRIP * SOFTER}
    haste = 1.0 / FRICTION_LEADS[RK4 if settings.get("integrator") == "RK4" else EULER]

    def pair(step: float) -> PairFields:
        late = np.array([-1.0, -haste * IMPEDANCE / step])
        return {**coulomb_pair(step, SOFTER), "solreffriction": late}

    return replace(chosen, options=options, pair=pair, softening=SOFTER)


def off_line(problem: CapsuleProblem) -> bool:
    """Whether the motion is one of the plane that has no formula."""
    return problem.setup.in_plane and not isinstance(problem.motion, ResidualMotion)


def set_contacts(spec: mujoco.MjSpec, chosen: ContactProfile, friction: float, step: float) -> None:
    """Set every contact pair, and the options that go with it, to a profile at `step` [s]; what
    the profile leaves open is as MuJoCo ships it, whatever the file says."""
    shipped = mujoco.MjSpec()
    pair = shipped.add_pair()
    fields = {name: np.array(getattr(pair, name)) for name in PAIR} | dict(chosen.pair(step))
    for name in OPTIONS:
        setattr(spec.option, name, getattr(shipped.option, name))
    options.apply(spec, chosen.options, step)
    for contact in spec.pairs:
        contact.friction[:2] = friction
        contact.condim = 3 if friction > 0.0 else 1  # MuJoCo lifts a friction of 0 to 1e-5
        for name, value in fields.items():
            setattr(contact, name, value)


def gravity(setup: CapsuleSetup) -> list[float]:
    """Gravity in the world [m/s^2], shape (3,): pulling along the line, pressing onto the plane."""
    line = setup.heading + setup.direction
    return [setup.pull * math.cos(line), setup.pull * math.sin(line), -setup.press]


def armature(setup: CapsuleSetup) -> float:
    """Armature of the slider's joint [kg]: a power of ten, HOLD times the slider's mass or more."""
    return float(10.0 ** math.ceil(math.log10(HOLD * setup.capsule.slider_mass)))


def tilt_inertia(problem: CapsuleProblem) -> float:
    """Moments of inertia of the body about axes across the vertical [kg m^2], in two digits.

    They have no part in a motion without heights, and are free: (M + m)/3 sum |A_i - mu r|^2 keeps
    every tilting of the body on its contacts as slow as twice its heaving, or slower, whatever the
    triangle and wherever the slider is; and J/2 at least, or no such body could be.
    """
    capsule = problem.setup.capsule
    centres = capsule.mass_ratio * slider_places(problem)
    arms = np.asarray(capsule.supports)[None] - centres[:, None]
    spread = float(np.square(arms).sum(axis=(1, 2)).max())
    least = max((capsule.body_mass + capsule.slider_mass) / 3 * spread, capsule.inertia / 2)
    unit = 10.0 ** (math.floor(math.log10(least)) - 1)
    return float(f"{math.ceil(least / unit * (1 - 1e-12)) * unit:.1e}")


def slider_places(problem: CapsuleProblem) -> Any:
    """Places of the slider relative to C [m], shape (n, 2), among which are those farthest out: the
    ends of its line, or many on its way in the plane."""
    path = getattr(getattr(problem.motion, "manoeuvre", problem.motion), "path", None)
    if problem.setup.plane_velocity is not None and isinstance(path, SliderPath):
        return path.kinematics(np.linspace(0.0, path.duration, PLACES))[0]
    return problem.slider_ends
