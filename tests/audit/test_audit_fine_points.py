"""Where a reference needs finer tolerances, and where rounding decides a motion."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit import audit as audit_module
from plumbob.engines.audit import reference as reference_module
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.reference import certified
from plumbob.tests.audit.scenes_as_models import audit_of, ball

BUDGET = 60.0  # [s], far more than these take

# Small steps of RK4 on a smooth motion: what the two methods differ by is as large as their error.
ARM = """
<mujoco>
  <option timestep="0.002" integrator="RK4"/>
  <worldbody><body><joint axis="0 1 0"/><geom type="capsule" size=".02" fromto="0 0 0 .5 0 0"/>
    <body pos=".5 0 0"><joint axis="0 1 0"/><geom type="capsule" size=".02" fromto="0 0 0 .5 0 0"/>
    </body></body></worldbody>
</mujoco>
"""


@pytest.mark.long
def test_tolerances_are_refined_where_they_do_not_resolve_the_error(monkeypatch):
    found = audit_of(ARM, duration=0.4)
    assert found.until == pytest.approx(0.4)
    assert found.resolved
    monkeypatch.setattr(audit_module, "refined", lambda model, script, reference, *_: reference)
    coarse = audit_of(ARM, duration=0.4)
    assert not coarse.resolved
    assert found.uncertainty < coarse.uncertainty / 10
    assert abs(coarse.error - found.error) <= coarse.uncertainty + found.uncertainty


def same_bits(one, other):
    pairs = (
        (one.course.states, other.course.states),
        (one.uncertainty, other.uncertainty),
    )
    return all(np.array_equal(here, there) for here, there in pairs)


@pytest.mark.parametrize("chatter", [0, 20])
def test_a_confirmation_beside_its_reference_has_the_same_bits(chatter, monkeypatch):
    """Of a ball that bounces, sharp or, where its contacts are taken for chatter, over layers."""
    monkeypatch.setattr(reference_module, "CHATTER", chatter)
    own = own_model(ball(0.13), "ball")
    motion = script(own, duration=0.2)
    alone = certified(own, motion, Allowance(BUDGET))
    with ThreadPoolExecutor(2) as executor:
        beside = certified(own, motion, Allowance(BUDGET, executor=executor))
    assert bool(alone.widths) == (chatter == 0)
    assert same_bits(alone, beside)
    assert (alone.why, alone.widths) == (beside.why, beside.widths)
