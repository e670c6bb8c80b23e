"""Settings to paste: in three bodies that are not plumbob's, stopping distances are as predicted.

A free body slides at 30 degrees to the axes and stops under Coulomb friction after v^2/(2 f g). The
leading errors of Euler's step and of a tilt by the deflection of the contacts are predicted.
"""

import math

import mujoco
import numpy as np
import pytest

from plumbob.engines.abilities import SettingsToPaste
from plumbob.engines.adapters.mujoco.settings_to_paste import OWN_STIFFNESS
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method

FRICTION = 0.3
GRAVITY = 9.81
SPEED = 0.5
HEADING = math.pi / 6
EXACT = SPEED**2 / (2 * FRICTION * GRAVITY)  # stopping distance [m]
STEPS = (2e-3, 1e-3, 1e-4)
# The rest is of third order: 2 % of v dt/2 covers it at 2 ms, where tilts are largest.
REST = 0.02


def _foot(i, x, y, z):
    return f'<geom name="foot_{i}" type="sphere" size=".01" pos="{x} {y} {z}" mass=".01"/>'


def _leg(i, angle):
    x = 0.2 * math.cos(angle)
    y = 0.2 * math.sin(angle)
    z = -0.2
    knee = f"{0.95 * x} {0.95 * y} {0.95 * z}"
    leg = f'<geom type="capsule" size=".008" fromto="0 0 0 {knee}" mass=".3"/>'
    return leg + _foot(i, x, y, z)


CORNERS = [(x, y) for x in (1, -1) for y in (1, -1)]
BOX = '<geom type="box" size=".15 .1 .03" mass="1.96"/>' + "".join(
    _foot(i, 0.15 * x, 0.1 * y, -0.03) for i, (x, y) in enumerate(CORNERS)
)
STAND = '<geom type="cylinder" size=".08 .02" mass="1.5"/>' + "".join(
    _leg(i, angle) for i, angle in enumerate((0.4, 1.9, 3.6, 5.2))
)
WHEELED = '<geom type="box" size=".2 .12 .04" mass="4" pos="0 0 .03"/>' + "".join(
    f'<geom name="foot_{i}" type="cylinder" size=".05 .015" pos="{0.15 * x} {0.14 * y} 0" '
    'euler="90 0 0" mass=".3"/>'
    for i, (x, y) in enumerate(CORNERS)
)
BODIES = {  # geoms, height of the origin [m], stiffness: wheels touch at eight points
    "four-footed box": (BOX, 0.04, None),
    "four-legged stand": (STAND, 0.21, None),
    "wheeled base": (WHEELED, 0.05, 0.1),
}
METHODS = ("mujoco/euler+coulomb", "mujoco/implicitfast+coulomb", "mujoco/rk4+coulomb")


def snippets(method, step, stiffness=None):
    settings = engine_of(find_method(method)).ability(SettingsToPaste)
    return settings.write(find_method(method), step, stiffness, FRICTION).snippets


def own_model(body, mjcf, python=""):
    """The body with settings pasted into its file, their one pair written for every foot."""
    geoms, height, _ = BODIES[body]
    line = '<pair geom1="floor" geom2="foot_1"/>'
    pairs = "".join(line.replace("foot_1", f"foot_{i}") for i in range(4))
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco>{mjcf.replace(line, pairs)}"
        f'<worldbody><geom name="floor" type="plane" size="5 5 1"/>'
        f'<body name="base" pos="0 0 {height}"><freejoint/>{geoms}</body></worldbody></mujoco>'
    )
    exec(python, {"model": model})  # the line that a user pastes
    return model


def _slide(model):
    """The distance [m] that the body's centre of mass slides after it has settled, and h^2 over
    sum(b_i^2) of the contacts on which it then stands."""
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=2000)
    data.qpos[:2], data.qvel[:] = 0.0, 0.0
    way = np.array([math.cos(HEADING), math.sin(HEADING)])
    data.qvel[:2] = SPEED * way
    mujoco.mj_forward(model, data)
    start = np.array(data.subtree_com[1])
    arms = np.array(data.contact.pos) - start
    shape = float(np.square(arms[:, 2]).mean() / np.square(arms[:, :2] @ way).sum())
    mujoco.mj_step(model, data, nstep=round(0.25 / model.opt.timestep))
    mujoco.mj_forward(model, data)
    return float(np.linalg.norm(data.subtree_com[1, :2] - start[:2])), shape


@pytest.mark.long(keep=5)
@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("variant", [0, 1], ids=["mjcf", "softened"])
def test_stopping_distances_are_as_predicted(variant, method, body, step):
    stiffness = BODIES[body][2]
    snippet = snippets(method, step, stiffness)[variant]
    distance, shape = _slide(own_model(body, snippet.mjcf, snippet.python))
    leading = 0.0 if "rk4" in method else -SPEED * step / 2
    tilt = -FRICTION * GRAVITY * shape * (step / (stiffness or OWN_STIFFNESS)) ** 2
    assert distance - EXACT == pytest.approx(leading + tilt, abs=REST * SPEED * step / 2)
