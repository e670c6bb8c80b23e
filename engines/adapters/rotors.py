"""Rotors so heavy that no load changes their motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:  # this module is loaded at each start, records of mechanisms are not
    from plumbob.engines.mechanism import JointKind, Mechanism


def moved_inertia(mechanism: Mechanism, kind: JointKind) -> float:
    """The largest inertia that a joint of a kind can have to move: the mass of all bodies [kg] for
    a slide, their largest moment of inertia about the world's origin [kg m^2] for a hinge."""
    masses = np.array([body.mass for body in mechanism.bodies])
    if kind == "slide":
        return float(masses.sum())
    reach = [0.0]  # the largest distance of each frame from the world's
    for body in mechanism.bodies[1:]:
        reach.append(reach[body.parent] + float(np.linalg.norm(body.place)))
    arms = reach + np.linalg.norm([body.centre for body in mechanism.bodies], axis=1)
    spread = sum(float(np.trace(body.inertia)) for body in mechanism.bodies)
    return float(masses @ np.square(arms)) + spread
