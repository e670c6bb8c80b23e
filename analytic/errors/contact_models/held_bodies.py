"""Errors of steps on bodies that are held: a stack, a body between two fingers, a cube on a slope.

With hard contacts, a body at rest has no error. With soft contacts, the errors are the depth of
each contact and the drift of friction. A cube that slides is stepped with friction that ends the
slip within a step.
"""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.contact_models.soft_friction import STEPPED, Held, drifted
from plumbob.analytic.errors.sliding_motion.sliding_errors import stepped
from plumbob.analytic.errors.smooth_motion.scheme_steps import whole_steps
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.incline import Incline
from plumbob.analytic.systems.pinch import Pinch
from plumbob.analytic.systems.stack import Stack
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors, apart

CORNERS = 4  # corners of a face, which carry equal loads because the face does not turn
DEEPEST = 0.4  # chosen: largest depth over the edge; beyond 0.5 contacts push the cube through
FINGERS = 2
TIP = 0.2  # chosen: radius of a fingertip over the cube's edge


def corners(stack: Stack) -> list[Held]:
    """Returns one corner contact of each cube's lower face, from the lowest cube to the top."""
    below = np.concatenate([[0.0], 1.0 / stack.masses[:-1]])
    weights = below + 1.0 / stack.masses
    parts = stack.masses / CORNERS
    loads = stack.normal_forces / CORNERS
    return [
        Held(float(load), 0.0, np.zeros(2), float(weight), float(part))
        for load, weight, part in zip(loads, weights, parts, strict=True)
    ]


def stack_errors(stack: Stack) -> StepErrors:
    """Returns the errors of steps on a stack.

    The errors are empty for schemes that are not stepped here. They are empty, too, if a contact is
    so deep that it would push the wrong way.
    """

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        still = np.zeros(len(times))
        if scheme.contact is None:
            return {"top": still} if scheme.integrator == EULER else {}
        depths = [held.depth(scheme.contact, step) for held in corners(stack)]
        if scheme.integrator not in STEPPED or max(depths) > DEEPEST * stack.size:
            return {}
        deflected = {"top": still - sum(depths)}
        return SteppedErrors(deflected, stack.uncertainty(times), lasting=deflected)

    return StepErrors(error)


def fingertip(pinch: Pinch) -> Held:
    """Returns the contact of one of the fingers."""
    weight = 1.0 / pinch.mass + 1.0 / pinch.finger_mass
    pull = pinch.pull / FINGERS
    part = pinch.mass / FINGERS
    return Held(pinch.normal_force, pinch.friction, pull, weight, part)


def pinch_errors(pinch: Pinch) -> StepErrors:
    """Returns the errors of steps on a pinched body.

    The errors are empty for schemes that are not stepped here. They are empty, too, if the friction
    pyramid does not hold the body, or if a contact is too deep.
    """

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        held = fingertip(pinch)
        still = pinch.observe(times)
        if scheme.contact is None:
            return still if scheme.integrator == EULER else {}
        drift = drifted(scheme, held, step, whole_steps(times, step))
        deep = held.depth(scheme.contact, step) > TIP * pinch.size
        if deep or not len(drift) or drift[0].max() > pinch.size / 2.0:  # off the face
            return {}
        slipped = dict(zip(still, drift, strict=True))
        return SteppedErrors(slipped, pinch.uncertainty(times), lasting=slipped)

    return StepErrors(error)


def corner(cube: Incline) -> Held:
    """Returns the contact of one of the cube's lower corners."""
    pull = cube.pull * np.array([np.cos(cube.heading), np.sin(cube.heading)])
    part = cube.mass / CORNERS
    return Held(part * cube.press, cube.friction, part * pull, 1.0 / cube.mass, part)


def incline_errors(cube: Incline) -> StepErrors:
    """Returns the errors of steps on a cube on a slope.

    The errors are empty for schemes that are not stepped here. They are empty, too, for a cube that
    slides on soft contacts, because these contacts chatter.
    """

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        exact = cube.observe(times)
        marks = whole_steps(times, step)
        if scheme.contact is None and scheme.integrator == EULER:
            pulls = [cube.pull] * int(marks[-1])
            limit = cube.friction * cube.press
            reached = stepped(scheme, step, cube.speed, pulls, limit)[:, marks]
            rounded = ULP * (abs(cube.speed) + cube.gravity * times)
            return SteppedErrors(
                apart(dict(zip(("x", "speed"), reached, strict=False)), exact),
                {"x": rounded * (step + times), "speed": rounded},
            )
        drift = drifted(scheme, corner(cube), step, marks)
        if cube.speed or not len(drift):
            return {}
        slipped = dict(zip(exact, drift, strict=True))
        return SteppedErrors(slipped, cube.uncertainty(times), lasting=slipped)

    return StepErrors(error)
