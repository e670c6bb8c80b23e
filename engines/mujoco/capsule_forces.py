"""Forces between the capsule and the plane, read off MuJoCo's contacts at a sample."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np

from engines.mujoco.translation import Probe, Values
from models.tripod_capsule.staging import Staging


def reading(staging: Staging, observed: bool) -> Probe:
    """Normal forces N_i and friction along the line [N], over the step that begins, if they are
    `observed`; and as channels the number of contacts, and what is left of the balance of momentum
    [N]: the actuator is inside, so the plane and gravity alone may change it."""
    capsule, angle = staging.capsule, staging.heading + staging.direction
    line = np.array([math.cos(angle), math.sin(angle), 0.0])
    both = capsule.body_mass + capsule.slider_mass
    driven = staging.relative_velocity is not None

    def probe(model: mujoco.MjModel, data: mujoco.MjData) -> Callable[[], tuple[Values, Values]]:
        first, body = model.geom("support_1").id, model.body("body").id
        force = np.zeros(6)

        def read() -> tuple[Values, Values]:
            normal, friction = [0.0, 0.0, 0.0], 0.0
            contacts = data.contact
            pairs, across = contacts.geom, contacts.frame.reshape(-1, 3, 3)[:, 1:] @ line
            for i in range(data.ncon):
                mujoco.mj_contactForce(model, data, i, force)
                normal[pairs[i].max() - first] += force[0]
                friction += float(across[i] @ force[1:3])
            pushed = both * (data.qacc[:3] @ line - staging.pull)
            pushed += capsule.slider_mass * data.qacc[-1] if driven else 0.0
            seen = {f"normal_force_{i + 1}": float(normal[i]) for i in range(3)}
            return {**seen, "friction_force": friction} if observed else {}, {
                "contacts": float(data.ncon),
                "centre_of_mass": float(data.subtree_com[body] @ line),
                "momentum_residual": float(pushed) - friction,
            }

        return read

    return probe
