"""A slide with joints free, held against a box whose load is stiffly held, or not at all."""

import mujoco
import pytest

from plumbob.engines.abilities import UserModels
from plumbob.engines.adapters.mujoco import ENGINE
from plumbob.engines.audit.moving_joints import free_slide
from plumbob.engines.own_motion import Start
from plumbob.tests.audit.contacts.bodies_on_planes import model_text

FRICTION, GRAVITY, SPEED = 0.4, 9.81, 0.5
BASE, LOAD = 3.0, 2.0  # [kg]
SOFT = 0.02  # relative: default contacts, which are not rigid, differ by 0.006
FEET = "".join(
    f'<geom size=".02" pos="{x} {y} -.04" mass="0"/>'
    for x in (-0.2, 0.2)
    for y in (-0.15, 0.15)
)
BODY = f"""<geom type="box" size=".2 .15 .02" mass="{BASE}"/>{FEET}
<body pos="0 0 .02"><joint name="slide" type="slide" axis="1 0 0"/>
<geom type="box" size=".05 .05 .02" mass="{LOAD}" contype="0" conaffinity="0"/></body>"""
SERVO = '<actuator><position joint="slide" kp="{kp}" kv="{kv}"/></actuator>'


def slid(more):
    """The slide of the box, with `more` in the model."""
    model = mujoco.MjModel.from_xml_string(model_text(BODY, 0.06, friction=FRICTION, more=more))
    models = ENGINE.ability(UserModels)
    return free_slide(models.contacts(model, Start(), None, None), SPEED, 0.38)


@pytest.mark.long
@pytest.mark.parametrize(
    ("more", "sliding"),
    [
        (SERVO.format(kp=2e5, kv=800), BASE + LOAD),  # the load brakes with the base
        ("", BASE),  # the load goes on
    ],
)
def test_the_continuous_motion_is_that_of_two_bodies(more, sliding):
    """Friction of the whole weight brakes what is held: v^2 / (2 f g (M + m) / held)."""
    exact = SPEED**2 * sliding / (2 * FRICTION * GRAVITY * (BASE + LOAD))
    found = slid(more)
    assert found.certified == pytest.approx(exact, rel=SOFT)
    assert found.own == pytest.approx(exact, rel=SOFT)
    assert found.uncertainty < SOFT * exact
    assert found.until == pytest.approx(0.38)
    assert not found.why
