"""Means over many starts: a step that changes what is likely stands out, another does not."""

import numpy as np
import pytest

from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.ensemble import STANDS_OUT, STARTS, likely
from plumbob.tests.audit.scenes_as_models import ball, compiled, ready

# Two arms in a chain, that start high: a double pendulum.
DOUBLE = """<mujoco><option timestep="{}" integrator="{}"/><worldbody>
  <body><joint axis="0 1 0"/><geom type="capsule" size=".02" fromto="0 0 0 .5 0 .3"/>
  <body pos=".5 0 .3"><joint axis="0 1 0"/><geom type="capsule" size=".02" fromto="0 0 0 .5 0 0"/>
  </body></body></worldbody></mujoco>"""


def test_starts_are_near_and_repeat():
    model = ready(ball())
    starts = model.starts(STARTS, 1e-3)
    assert np.array_equal(starts, model.starts(STARTS, 1e-3))
    assert 0.0 < np.abs(starts - model.state).max() < 0.01
    assert np.allclose(np.linalg.norm(starts[:, 3:7], axis=1), 1.0)


@pytest.mark.long
def test_large_step_stands_out_and_an_accurate_one_does_not():
    means = {}
    for step, integrator in ((0.02, "Euler"), (0.005, "RK4")):
        model = ready(compiled(DOUBLE.format(step, integrator)))
        motion = script(model, duration=1.0, period=0.02)
        means[integrator] = likely(model, motion, round(0.02 / step), Allowance(30.0))
    large, accurate = means["Euler"], means["RK4"]
    assert large.most[1] > STANDS_OUT
    k = int(np.argmax(np.abs(np.array(large.own) - large.finer)))
    assert abs(large.own[k] - large.finer[k]) > 100 * abs(accurate.own[k] - accurate.finer[k])
