"""The same bits by one process and by several."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit import reference as reference_module
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.reference import certified
from plumbob.tests.audit.scenes_as_models import ball

BUDGET = 60.0  # [s], far more than these take


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
