"""Forces between the capsule and the plane, read off MuJoCo's contacts at a sample."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.mujoco.translation import Probe, Values


def reading(setup: CapsuleSetup) -> Probe:
    """Along a line the normal forces N_i and friction [N], over the step that begins; in the plane
    none of them. As channels the number of contacts, the common centre of mass [m], and what is
    left of the balance of momentum [N]: the actuator is inside, so the plane and gravity alone may
    change it."""
    capsule, angle = setup.capsule, setup.heading + setup.direction
    line = np.array([math.cos(angle), math.sin(angle), 0.0])
    both = capsule.body_mass + capsule.slider_mass

    def probe(model: mujoco.MjModel, data: mujoco.MjData) -> Callable[[], tuple[Values, Values]]:
        body, slider = model.body("body").id, model.body("slider").id
        driven = model.njnt > 1

        def along() -> tuple[Values, Values]:
            normal, force = _pressed(model, data)
            friction = float(force @ line)
            pushed = both * (data.qacc[:3] @ line - setup.pull)
            pushed += capsule.slider_mass * data.qacc[-1] if driven else 0.0
            seen = {f"normal_force_{i + 1}": float(normal[i]) for i in range(3)}
            return {**seen, "friction_force": friction}, {
                "contacts": float(data.ncon),
                "centre_of_mass": float(data.subtree_com[body] @ line),
                "momentum_residual": float(pushed) - friction,
            }

        def in_plane() -> tuple[Values, Values]:
            normal, force = _pressed(model, data)
            mujoco.mj_rnePostConstraint(model, data)
            pushed = capsule.body_mass * _acceleration(model, data, body)
            pushed = pushed + capsule.slider_mass * _acceleration(model, data, slider)
            x, y, _ = data.subtree_com[body]
            return {}, {
                "contacts": float(data.ncon),
                "least_normal_force": float(normal.min()),
                "centre_of_mass_x": float(x),
                "centre_of_mass_y": float(y),
                "momentum_residual": float(np.hypot(*(pushed - force)[:2])),
            }

        return in_plane if setup.in_plane else along

    return probe


def _pressed(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Array, Array]:
    """Normal forces N_i [N], shape (3,), and the sum of friction in the world [N], shape (3,)."""
    first, force = model.geom("support_1").id, np.zeros(6)
    normal, friction = np.zeros(3), np.zeros(3)
    pairs, across = data.contact.geom, data.contact.frame.reshape(-1, 3, 3)[:, 1:]
    for i in range(data.ncon):
        mujoco.mj_contactForce(model, data, i, force)
        normal[pairs[i].max() - first] += force[0]
        friction += force[1:3] @ across[i]
    return normal, friction


def _acceleration(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> Array:
    """Acceleration of a body's centre of mass in the world [m/s^2], shape (3,)."""
    found = np.zeros(6)
    mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_BODY, body, found, 0)
    return found[3:]
