"""Errors of steps on bodies that are held: a stack, a body between two fingers, a cube on a slope.

With hard contacts, a body at rest has no error. With soft contacts, the errors are the depth of
each contact and the drift of friction. A cube that slides is stepped with friction that ends the
slip within a step.
"""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.contact_models.soft_friction import (
    SOFT_FRICTION_SCHEMES,
    HeldContact,
    held_drift,
)
from plumbob.analytic.errors.sliding_motion.sliding_errors import stepped_motion
from plumbob.analytic.errors.smooth_motion.scheme_steps import whole_steps
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.incline import Incline
from plumbob.analytic.systems.pinch import Pinch
from plumbob.analytic.systems.stack import Stack
from plumbob.analytic.theory import Predicted, StepErrors, SteppedErrors, signal_differences

FACE_CORNERS = 4  # corners of a face; they carry equal loads because the face does not turn
# Chosen: largest ratio of a contact's depth to the cube's edge. From 0.5 on, contacts push the cube
# through.
LARGEST_RELATIVE_DEPTH = 0.4
FINGERS = 2
FINGERTIP_RADIUS = 0.2  # chosen: ratio of a fingertip's radius to the cube's edge


def corners(stack: Stack) -> list[HeldContact]:
    """Returns one corner contact of each cube's lower face, from the lowest cube to the top. The
    `weight` of a contact is the sum of the inverse masses of the two bodies that touch."""
    inverse_masses_below = np.concatenate([[0.0], 1.0 / stack.masses[:-1]])
    weights = inverse_masses_below + 1.0 / stack.masses
    masses = stack.masses / FACE_CORNERS
    loads = stack.normal_forces / FACE_CORNERS
    contacts = []
    for load, weight, mass in zip(loads, weights, masses, strict=True):
        contacts.append(HeldContact(float(load), 0.0, np.zeros(2), float(weight), float(mass)))
    return contacts


def stack_errors(stack: Stack) -> StepErrors:
    """Returns the errors of steps on a stack.

    The errors are empty for schemes that are not stepped here. They are empty, too, if a contact is
    so deep that it would push the wrong way.
    """

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        """Returns the error of the top cube's height: all depths together, downwards."""
        zeros = np.zeros(len(times))
        if scheme.contact is None:
            return {"top": zeros} if scheme.integrator == EULER else {}
        depths = [contact.depth(scheme.contact, step) for contact in corners(stack)]
        too_deep = max(depths) > LARGEST_RELATIVE_DEPTH * stack.size
        if scheme.integrator not in SOFT_FRICTION_SCHEMES or too_deep:
            return {}
        deflections = {"top": zeros - sum(depths)}
        return SteppedErrors(deflections, stack.uncertainty(times), lasting=deflections)

    return StepErrors(error)


def fingertip(pinch: Pinch) -> HeldContact:
    """Returns the contact of one finger. `load` is the force of this finger on the body, which the
    scene gives for each finger; the body's mass and pull are shared by all fingers. `weight` is the
    inverse effective mass of the contact [1/kg]."""
    return HeldContact(
        load=pinch.normal_force,
        friction=pinch.friction,
        pull=pinch.pull / FINGERS,
        weight=1.0 / pinch.mass + 1.0 / pinch.finger_mass,
        mass=pinch.mass / FINGERS,
    )


def pinch_errors(pinch: Pinch) -> StepErrors:
    """Returns the errors of steps on a pinched body.

    The errors are empty for schemes that are not stepped here. They are empty, too, if the friction
    pyramid does not hold the body, or if a contact is too deep.
    """

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        """Returns the errors of the slip along the load and of its speed."""
        contact = fingertip(pinch)
        exact = pinch.observe(times)  # zeros: the body does not move
        if scheme.contact is None:
            return exact if scheme.integrator == EULER else {}
        drift = held_drift(scheme, contact, step, whole_steps(times, step))
        too_deep = contact.depth(scheme.contact, step) > FINGERTIP_RADIUS * pinch.size
        if too_deep or not len(drift):
            return {}
        fingertip_leaves_face = drift[0].max() > pinch.size / 2.0
        if fingertip_leaves_face:
            return {}
        drifts = dict(zip(exact, drift, strict=True))
        return SteppedErrors(drifts, pinch.uncertainty(times), lasting=drifts)

    return StepErrors(error)


def corner(cube: Incline) -> HeldContact:
    """Returns the contact of one of the cube's lower corners."""
    pull = cube.pull * np.array([np.cos(cube.heading), np.sin(cube.heading)])
    mass = cube.mass / FACE_CORNERS
    return HeldContact(
        load=mass * cube.press,
        friction=cube.friction,
        pull=mass * pull,
        weight=1.0 / cube.mass,
        mass=mass,
    )


def incline_errors(cube: Incline) -> StepErrors:
    """Returns the errors of steps on a cube on a slope.

    The errors are empty for schemes that are not stepped here. They are empty, too, for a cube that
    slides on soft contacts, because these contacts chatter.
    """

    def error(scheme: Scheme, step: float, times: Array) -> Predicted:
        """Returns the errors of place and speed: of a slide in steps, or the drift of a held
        cube."""
        exact = cube.observe(times)
        marks = whole_steps(times, step)
        if scheme.contact is None and scheme.integrator == EULER:
            pulls = [cube.pull] * int(marks[-1])
            limit = cube.friction * cube.press
            x, speed, _ = stepped_motion(scheme, step, cube.speed, pulls, limit)[:, marks]
            rounding = ULP * (abs(cube.speed) + cube.gravity * times)
            return SteppedErrors(
                signal_differences({"x": x, "speed": speed}, exact),
                {"x": rounding * (step + times), "speed": rounding},
            )
        drift = held_drift(scheme, corner(cube), step, marks)
        if cube.speed or not len(drift):
            return {}
        drifts = dict(zip(exact, drift, strict=True))
        return SteppedErrors(drifts, cube.uncertainty(times), lasting=drifts)

    return StepErrors(error)
