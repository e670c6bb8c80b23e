"""A foot that chatters: its limit over a thin layer is Coulomb's closed form.

Default contacts couple slip to the normal force, so a foot that slides leaves the plane and falls
back, ever faster the smaller the step. Its limit stays at the threshold of touching: the mean load
is the weight, and it decelerates by f g.
"""

from __future__ import annotations

from itertools import product

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model import field as field_module
from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.audit import Audit, audited
from plumbob.engines.audit.controls import script

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


def audit_of(cone: str, friction: float = FRICTION) -> Audit:
    text = FOOT.format(cone=cone, friction=friction)
    model = own_model(mujoco.MjModel.from_xml_string(text), "foot", 0)
    return audited(model, script(model, duration=DURATION), "rest", 60.0)


def apart(found: Audit) -> np.ndarray:
    """From Coulomb's motion [m], at the ends of the control periods."""
    times = found.script.times
    exact = SPEED * times - FRICTION * GRAVITY * times**2 / 2
    return np.asarray(np.abs(found.reference.positions[:, 1, 0] - exact))


@pytest.mark.long
@pytest.mark.parametrize("cone", ["pyramidal", "elliptic"])
def test_a_foot_that_chatters_is_certified_where_coulomb_has_it(cone: str) -> None:
    found = audit_of(cone)
    assert "contacts chatter" in found.reference.not_smooth
    assert len(found.reference.widths) == 3
    assert found.until == pytest.approx(DURATION)
    assert found.uncertainty < 1e-6
    assert (apart(found) <= found.reference.uncertainty).all()
    assert found.resolved
    assert found.error > 1e-4  # of its own steps


@pytest.mark.long
def test_another_friction_is_not_certified_there() -> None:
    found = audit_of("pyramidal", 1.001 * FRICTION)
    assert apart(found)[-1] > 5 * found.uncertainty


@pytest.mark.long
def test_wrong_weights_within_the_layer_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the loads of contacts that act from the start of the layer on, the limit is another."""
    monkeypatch.setattr(
        field_module, "product", lambda states, repeat: product((True, True), repeat=repeat)
    )
    found = audit_of("pyramidal")
    assert found.until < DURATION or apart(found)[-1] > found.uncertainty


def test_more_contacts_than_the_layer_takes_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(field_module, "MOST_IN_LAYER", 0)
    found = audit_of("pyramidal")
    assert found.found is None
    assert "contacts chatter" in found.reference.why
    assert "1 contacts begin within" in found.reference.why
