"""The capsule in MuJoCo, reduced to one line: two slides, one of which has dry friction."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.engines.adapters.mujoco.capsule.readings import (
    acceleration,
    control,
    scale_tolerance,
)
from plumbob.engines.adapters.mujoco.contacts import JOINT_HARDENING, JOINT_IMPEDANCE
from plumbob.engines.adapters.mujoco.translation import Observed, Translation, read
from plumbob.engines.method import Unsupported
from plumbob.models.tripod_capsule.model import armature, set_slider
from plumbob.models.tripod_capsule.observed import observed_on_a_line


def build(mjcf: Path, problem: CapsuleProblem, step: float) -> Translation:
    """The translation of a problem on one line, in the model file `mjcf` of the reduced model.
    Raises Unsupported if the body turns."""
    setup = problem.setup
    motion = problem.motion
    coasting = motion.kind == "coasting"
    if coasting and motion.centre is not None:
        raise Unsupported("the reduced model has one line, and here the body turns")
    spec = read(mjcf)
    capsule = setup.capsule
    # There is one scalar constraint, which one iteration of Gauss-Seidel solves to round-off.
    spec.option.solver = mujoco.mjtSolver.mjSOL_PGS
    spec.option.gravity = [setup.pull, 0.0, -setup.press]
    spec.body("body").mass = capsule.body_mass
    set_slider(spec, setup)
    scale_tolerance(spec, setup, armature(setup))
    joint = spec.joint("body")
    weight = (capsule.body_mass + capsule.slider_mass) * setup.press
    joint.frictionloss = capsule.friction * weight
    joint.solimp_friction = [JOINT_IMPEDANCE, JOINT_IMPEDANCE, 1e-3, 0.5, 2.0]
    joint.solref_friction = [-1.0, -JOINT_IMPEDANCE / step]

    def tune(model: mujoco.MjModel) -> None:
        """Makes friction stiffer than a file can."""
        model.dof_invweight0[0] *= JOINT_HARDENING

    def observe(qpos: Array, qvel: Array) -> Observed:
        """The observables of coordinates, shape (n, 2), or (n, 1) if the slider does not move."""
        stroke, stroke_rate = np.zeros((2, len(qpos)))
        if qpos.shape[1] > 1:
            stroke, stroke_rate = qpos[:, 1], qvel[:, 1]
        return observed_on_a_line(setup, qpos[:, 0], qvel[:, 0], stroke, stroke_rate), {}

    speed = float(np.hypot(*setup.velocity))
    start = np.array([speed] if setup.relative_velocity is None else [speed, 0.0])
    return Translation(
        spec,
        qpos=np.zeros(len(start)),
        qvel=start,
        observe=observe,
        control=control(setup, step),
        changing_control=acceleration(problem),
        sensors=None if coasting else _forces,
        probe=partial(_friction, setup),
        visual=spec.copy(),
        tune=tune,
    )


def _friction(setup: CapsuleSetup, model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Friction on the body, and the force on the slider [N], shape (2,)."""
    total_mass = setup.capsule.body_mass + setup.capsule.slider_mass
    slider = model.body("slider").id
    masses = np.array([total_mass, setup.capsule.slider_mass][: model.nv])
    # Friction follows from the accelerations, which the solver finds to round-off. It finds forces
    # only to its tolerance.
    friction = float(masses @ data.qacc) - total_mass * setup.pull
    mujoco.mj_rnePostConstraint(model, data)
    return np.array([friction, data.cfrc_int[slider, 3]])


def _forces(forces: Array) -> Observed:
    """The readings of `_friction`, shape (n, 2), as observables."""
    return {"friction_force": forces[:, 0], "driving_force": forces[:, 1]}, {}
