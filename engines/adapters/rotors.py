"""Inertia of rotors that are so heavy that no load changes their motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:  # imported only for types: `plumbob list` needs no records of mechanisms
    from plumbob.engines.mechanism import JointKind, Mechanism


def moved_inertia(mechanism: Mechanism, kind: JointKind) -> float:
    """An upper bound on the inertia that a joint of this kind moves: for a slide the mass of all
    bodies [kg], for a hinge their largest moment of inertia about the world's origin [kg m^2]."""
    masses = np.array([body.mass for body in mechanism.bodies])
    if kind == "slide":
        return float(masses.sum())
    reach = [0.0]  # [m] largest distance of each body's frame from the world's origin
    for body in mechanism.bodies[1:]:
        reach.append(reach[body.parent] + float(np.linalg.norm(body.place)))
    arms = reach + np.linalg.norm([body.centre for body in mechanism.bodies], axis=1)
    spread = sum(float(np.trace(body.inertia)) for body in mechanism.bodies)
    return float(masses @ np.square(arms)) + spread
