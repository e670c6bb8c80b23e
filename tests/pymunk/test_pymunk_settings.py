"""`plumbob settings` for pymunk: a body that stands on the pasted feet stops as predicted."""

import math

import pymunk
import pytest

from plumbob.engines.abilities import SettingsToPaste
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method

FRICTION = 0.3
GRAVITY = 9.81
SPEED = 0.5
HEADING = math.pi / 6
EXACT = SPEED**2 / (2 * FRICTION * GRAVITY)  # stopping distance [m]
CORNERS = [(x, y) for x in (0.15, -0.15) for y in (0.1, -0.1)]
REST = 2e-3  # of v dt/2: the next order of the step, dt f g/v = 0.012 at 2 ms, and iterations


def _python(method, step):
    settings = engine_of(find_method(method)).ability(SettingsToPaste)
    found = settings.write(find_method(method), step, None, FRICTION)
    return found.snippets[0].python.partition("while running")[0], found.stop_error_per_speed


def _block():
    space = pymunk.Space()
    body = pymunk.Body(2.0, 2.0 * (0.3**2 + 0.2**2) / 12)
    body.velocity = SPEED * math.cos(HEADING), SPEED * math.sin(HEADING)
    space.add(body)
    return space, body


def _distance(space, body, step):
    for _ in range(round(0.25 / step)):
        space.step(step)
    return float(abs(complex(*body.position)))


@pytest.mark.parametrize("step", [2e-3, 1e-3, 1e-4])
def test_a_stopping_distance_is_as_predicted(step):
    space, body = _block()
    code, predicted = _python("pymunk/feet", step)
    exec(code, {"space": space, "body": body, "anchors": CORNERS})  # what a user pastes
    assert predicted == step / 2
    error = _distance(space, body, step) - EXACT
    assert error == pytest.approx(predicted * SPEED, rel=REST)
    assert abs(body.angle) < 1e-9


def test_pasted_joints_close_in_a_step():
    space, body = _block()
    joint = pymunk.PivotJoint(space.static_body, body, (0.0, 0.0))
    space.add(joint)
    exec(_python("pymunk/tight", 1e-3)[0], {"space": space})
    assert joint.error_bias == 0.0
