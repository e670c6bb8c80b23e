"""A foot that chatters: its limit over a thin layer is Coulomb's closed form.

Default contacts couple slip to the normal force, so a foot that slides leaves the plane and falls
back, ever faster the smaller the step. Its limit stays at the threshold of touching: the mean load
is the weight, and it decelerates by f g.
"""

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit import reference as reference_module
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.reference import WIDTHS, certified, running_maximum
from plumbob.tests.audit.scenes_as_models import audit_of, compiled

FRICTION, GRAVITY, SPEED = 0.3, 9.81, 1.0
DURATION = 0.06  # [s]: a friction that differs by 1e-3 shows by 5e-6 m, twenty uncertainties
FOOT = """
<mujoco>
  <option timestep="0.002" cone="{cone}"/>
  <default><geom friction="{friction}"/></default>
  <worldbody><geom name="floor" type="plane" size="9 9 1"/>
    <body name="foot"><joint type="slide" axis="1 0 0"/><joint type="slide"/>
      <geom name="foot" size=".05" mass="1" pos="0 0 .05"/></body></worldbody>
  <keyframe><key qvel="1 0"/></keyframe>
</mujoco>
"""
# A pole that leans and begins to fall with its foot on the ground: how long the foot is within a
# layer, at first at rest, goes as the root of its width, and its slip with it.
POLE = """
<mujoco>
  <option timestep="0.0025"/>
  <worldbody><geom type="plane" size="9 9 1"/>
    <body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
      <joint axis="0 1 0"/><geom type="capsule" size=".05" fromto="0 0 .05 .1 0 .6" friction=".5"/>
    </body></worldbody>
</mujoco>
"""


def foot(cone, friction=FRICTION):
    return audit_of(FOOT.format(cone=cone, friction=friction), keyframe=0, duration=DURATION)


def apart(found):
    """From Coulomb's motion [m], at the ends of the control periods."""
    times = found.script.times
    exact = SPEED * times - FRICTION * GRAVITY * times**2 / 2
    return np.asarray(np.abs(found.model.poses(found.reference.states)[:, 1, 0] - exact))


@pytest.mark.long
@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
def test_a_foot_that_chatters_is_certified_where_coulomb_has_it(cone):
    found = foot(cone)
    assert "contacts chatter" in found.reference.not_smooth
    assert len(found.reference.widths) == 3
    assert found.until == pytest.approx(DURATION)
    assert found.uncertainty < 1e-6
    assert (apart(found) <= found.reference.uncertainty).all()
    assert found.resolved
    assert found.error > 1e-4  # of its own steps


def test_a_certificate_of_layers_holds_where_their_distance_goes_as_a_root(monkeypatch):
    own = own_model(compiled(POLE), "pole")
    motion = script(own, duration=0.1)
    sharp = certified(own, motion, Allowance(60.0))
    assert not sharp.widths
    assert sharp.uncertainty[-1] < 1e-7
    monkeypatch.setattr(reference_module, "CHATTER", 0)  # its first event is taken for chatter
    layered = certified(own, motion, Allowance(60.0))
    assert layered.widths == WIDTHS
    off = running_maximum(np.linalg.norm(layered.corners - sharp.corners, axis=2))
    assert off[-1] > 1e-5
    assert (off <= layered.uncertainty + sharp.uncertainty).all()
    assert layered.uncertainty[-1] < 1.5 * off[-1]
