"""A certificate against small steps, of a small model: it holds, and one that does not is seen."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.audit import audited
from plumbob.engines.audit.controls import script
from plumbob.tests.audit.robots.certificates import HOLDS, OPEN, OUTSIDE, confirmations, verdict

# Two legs that part under a body, their feet on the ground: they slide, and chatter from 0.65 s on.
LEGS = """
<mujoco>
  <option timestep="0.0025"/>
  <default><geom type="capsule" size=".04" friction=".7"/></default>
  <worldbody><geom type="plane" size="9 9 1"/>
    <body pos="0 0 .5"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
      <joint axis="0 1 0"/><geom size=".05" fromto="-.1 0 .1 .2 0 .2"/>
      <body><joint axis="0 1 0" damping=".1"/><geom fromto="0 0 0 .2 0 -.46"/></body>
      <body><joint axis="0 1 0" damping=".1"/><geom fromto="0 0 0 -.12 0 -.46"/></body>
    </body></worldbody>
</mujoco>
"""


@pytest.mark.long
def test_a_certificate_of_chatter_holds_and_a_wrong_one_is_outside():
    own = own_model(mujoco.MjModel.from_xml_string(LEGS), "legs")
    found = audited(own, script(own, duration=0.8), "rest", 10.0)
    assert found.complete
    assert found.reference.widths
    assert found.resolved
    confirmed = confirmations(found, 1.0)
    assert verdict(found, confirmed) == HOLDS
    assert confirmed[0].error == pytest.approx(found.error, rel=0.01)
    moved = 2.0 * (found.uncertainty + max(float(c.scatter[-1]) for c in confirmed))
    reference = replace(found.reference, positions=found.reference.positions + moved)
    wrong = replace(found, reference=reference)
    assert verdict(wrong, confirmations(wrong, 1.0)) == OUTSIDE
    finer = replace(found.reference, uncertainty=1e-6 * found.reference.uncertainty)
    apart = [replace(c, apart=0.0 * c.apart) for c in confirmed]
    assert verdict(replace(found, reference=finer), apart) == OPEN
