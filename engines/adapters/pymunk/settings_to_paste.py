"""Settings to paste into a user's space: friction that converges, and joints that close, as Python.

This module needs no pymunk. capsule_above.py explains the friction.
"""

from __future__ import annotations

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import Settings, Snippet
from plumbob.engines.method import Method

FEET = '''\
import pymunk

space.iterations = {iterations}

def foot(space, body, anchor, mass, limit):
    """A support at `anchor`, from the body's centre of mass [m], with friction of at most `limit`
    [N]; its `mass` is taken off the body."""
    part = pymunk.Body(mass, float("inf"))  # cannot turn
    part.position = body.local_to_world(anchor)
    part.velocity = body.velocity_at_local_point(anchor)
    body.mass -= mass
    body.moment -= mass * (anchor[0] ** 2 + anchor[1] ** 2)
    pin = pymunk.PivotJoint(body, part, anchor, (0.0, 0.0))
    pin.error_bias = 0.0  # closed in one step
    ground = pymunk.PivotJoint(part, space.static_body, (0.0, 0.0), (0.0, 0.0))
    ground.max_bias = 0.0  # holds no place: friction alone
    ground.max_force = limit
    space.add(part, pin, ground)
    return ground  # set its max_force again when the normal force changes

weight = 9.81 * body.mass
for anchor in anchors:  # where the body stands, for example its four wheels
    limit = {friction:g} * weight / len(anchors)  # friction times the normal force
    foot(space, body, anchor, 0.1 * weight / 9.81 / len(anchors), limit)
'''
LOOP = "while running:\n    space.step({step:g})"


def settings(method: Method, step: float, stiffness: float | None, friction: float) -> Settings:
    """The settings to paste for `method` at `step` [s]; raises ParameterError."""
    if stiffness is not None:
        raise ParameterError("stiffness", stiffness, "left out: it is for mujoco's contacts")
    loop = LOOP.format(step=step)
    if method.settings.get("model") == "feet":
        code = FEET.format(iterations=method.settings["iterations"], friction=friction)
        snippet = Snippet(
            "Python, in a view from above without gravity",
            "",
            f"{code}\n{loop}",
            f"stopping distance: {step / 2:.6g} s times the initial speed; the iterations leave "
            "about 1e-5 of a change of velocity",
            "two to three times a step of the same body on bare pivot joints with 10 iterations",
            "for one body that slides, turns and stops under dry friction, its supports about its "
            "centre of mass; normal forces are those of statics unless max_force is set in each "
            "step; tried on a block with four feet",
        )
        return Settings(method.name, step, step / 2, (snippet,))
    if "error_bias" in method.settings:
        snippet = Snippet(
            "Python",
            "",
            f"for joint in space.constraints:\n    joint.error_bias = 0.0\n{loop}",
            "of first order in the step, without the energy that joints with default settings lose",
            "none",
            "for smooth motion on joints, such as a pendulum's",
        )
        return Settings(method.name, step, None, (snippet,))
    raise ParameterError("method", method.name, "pymunk/feet or pymunk/tight")
