"""A slide with joints free, under the model's own controls, compared with its certified motion.

The contact audit slides a body as one rigid piece. Servos give way while it brakes, so that the
whole model stops elsewhere. The model's continuous motion shows how far away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.reference import certified
from plumbob.engines.own_contacts import ContactModel
from plumbob.engines.own_motion import NotCertifiable

BUDGET = 10.0  # [s] processor time for the reference


@dataclass(frozen=True)
class FreeSlide:
    """The distance that the body has gone along the plane's x axis, from the same speed."""

    own: float | None = None  # [m] at the model's own step; None if the run diverges
    certified: float | None = None  # [m] by the continuous motion; None if it is not known
    uncertainty: float = math.inf  # [m]
    until: float = 0.0  # [s] time up to which the motion is certified
    why: str = ""  # why the motion is not known, or not to the end


def free_slide(model: ContactModel, speed: float, duration: float) -> FreeSlide:
    """Returns the slide of the whole `model`, settled under its own controls, from `speed` [m/s]
    for `duration` [s]."""
    try:
        whole, body, axis = model.let_go(speed)
        motion = script(whole, "rest", duration)
    except NotCertifiable as why:
        return FreeSlide(why=str(why))
    reference = certified(whole, motion, Allowance(BUDGET))
    index = reference.known
    run = whole.stepped(motion, whole.integrator, motion.parts(whole.step))
    distances = [
        float((places[index, body] - places[0, body])[:3] @ axis)
        for places in map(whole.poses, (run.states, reference.course.states))
    ]
    own_distance = distances[0] if math.isfinite(distances[0]) else None
    until = float(motion.times[index])
    if not index:
        return FreeSlide(own=own_distance, why=reference.why)
    return FreeSlide(
        own_distance, distances[1], float(reference.uncertainty[index]), until, reference.why
    )
