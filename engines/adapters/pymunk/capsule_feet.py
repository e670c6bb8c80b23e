"""The capsule seen from above, standing on feet: friction that converges.

A joint to the ground with a largest force is Coulomb friction only where it is solved alone, that
is for the point mass that it holds: clamped on a rigid body off its centre, its impulse has the
direction of K^-1 v, not of v. So each support is a small body that cannot turn, with a joint of its
own to the ground and a pin to the body, and the solver's sweeps carry the forces from one to the
other. The feet's masses, and what they add to the inertia, are taken off the body.

A foot may stand beside the place where it is pinned: it has no part in friction, which acts on the
body at the pin. While the body turns, a pin has to close what opens, for else it leaves the feet
behind the turn. While it does not, a pin must not: feet that friction holds cannot follow, closing
strains them against each other more in every step, and that uses friction up (near its limit it
lets the body creep, 0.1 mm in 10 s at 0.999 of it).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pymunk

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.pymunk.capsule_space import (
    NO_TURNING,
    Assembly,
    assembled,
    gripped,
    pinned,
    place,
)
from plumbob.engines.adapters.pymunk.capsule_sweeps import left_by_sweep, pin

SHARE = 0.1  # of the body's mass in each foot: lighter ones carry less from sweep to sweep
LEFT = 0.25  # of the body's inertia that the feet leave to it, at least
OPEN = 1.0  # error_bias of a joint that closes nothing


def foot_mass(capsule: Capsule) -> float:
    """Mass of a foot [kg]: SHARE of the body's, or what leaves LEFT of its inertia to it.

    With the feet's masses m_f the body keeps J - m_f sum A_i^2 - m_b c^2, c its own centre of mass,
    and m_b c^2 <= 3 m_f^2 sum A_i^2 / m_b.
    """
    spread = float(np.square(capsule.supports).sum())
    most = (1.0 - LEFT) * capsule.inertia / (capsule.body_mass * spread)
    return capsule.body_mass * min(SHARE, most / (1.0 + 3.0 * most))


def feet(setup: CapsuleSetup, step: float, turning: bool) -> Assembly:
    """The capsule on three feet, in a motion that has it turn or not; what friction can at each is
    yet to be told."""
    capsule = setup.capsule
    anchors = [complex(x, y) for x, y in capsule.supports]
    mass = foot_mass(capsule)
    rest = capsule.body_mass - 3 * mass
    own = -mass * sum(anchors) / rest
    moment = capsule.inertia - rest * abs(own) ** 2 - mass * sum(abs(a) ** 2 for a in anchors)
    bare = assembled(setup, rest, moment, own, step)
    pins, grips = [], []
    for anchor in anchors:
        foot = pymunk.Body(mass, NO_TURNING)
        place(setup, foot, anchor, own, step)
        pins.append(pinned(bare.body, foot, anchor - own))
        if not turning:
            pins[-1].error_bias = OPEN
        grips.append(gripped(bare.space, foot, 0j))
        bare.space.add(foot)
    bare.space.add(*pins, *grips)
    return replace(bare, pins=tuple(pins), grips=tuple(grips))


def feet_left_by_sweep(capsule: Capsule, slider: Array) -> float:
    """Largest share of a velocity that one sweep of the solver leaves while every foot is to rest,
    the slider at `slider` from C [m], shape (2,)."""
    mass, corners, count = foot_mass(capsule), np.asarray(capsule.supports), 11
    rest = capsule.body_mass - 3 * mass
    own = -mass * corners.sum(axis=0) / rest
    moment = float(capsule.inertia - rest * own @ own - mass * np.square(corners).sum())
    pins = [pin(count, corner - own, 5 + 2 * i) for i, corner in enumerate(corners)]
    grips = [np.eye(count)[5 + 2 * i : 7 + 2 * i] for i in range(3)]
    masses = [rest, rest, moment, *[capsule.slider_mass] * 2, *[mass] * 6]
    return left_by_sweep(masses, [pin(count, np.asarray(slider) - own, 3), *pins, *grips])


def few_feet_left_by_sweep(capsule: Capsule, gripping: int) -> float:
    """The same on a line, where all but so many feet slip."""
    mass, slip = foot_mass(capsule), np.eye(5)
    masses = [capsule.body_mass - 3 * mass, capsule.slider_mass, *[mass] * 3]
    pins = [slip[:1] - slip[i : i + 1] for i in range(1, 5)]
    return left_by_sweep(masses, [*pins, *(slip[i : i + 1] for i in range(2, 2 + gripping))])
