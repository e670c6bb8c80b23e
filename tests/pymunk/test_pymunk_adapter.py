"""pymunk's simple pendulum against the exact motion and the theory of its joint."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.adapters.pymunk import ENGINE
from plumbob.engines.adapters.pymunk.methods import CLOSING_RATE
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene

METHODS = {m.name: m for m in ENGINE.methods if "simple-pendulum" in m.systems}
DEFAULT, TIGHT = METHODS["pymunk/default"], METHODS["pymunk/tight"]


def run(name, method, step, duration, **settings):
    """One run of a scene of the simple pendulum, cut to `duration` [s]."""
    scene = replace(find_scene(f"simple-pendulum/{name}"), duration=duration)
    how = replace(method, settings={**method.settings, **settings})
    found, trajectory = measure(case_of(scene), how, step)
    assert trajectory is not None
    return found, trajectory


@pytest.mark.parametrize("step", [1e-3, 2.5e-4])
def test_joint_stays_open_while_the_bob_turns(step):
    # at speed w the opening settles at h w^2 L / 2 |beta + i w|; the speed changes by a tenth in
    # 1/beta, and so does the opening
    loose, tight = (run("rotating-fast", how, step, 3.0)[1] for how in (DEFAULT, TIGHT))
    late = loose.times > 1.5  # 1.5 s are ten times 1/beta
    speed = loose.observables["theta_dot"][late]
    steady = step * speed**2 / (2 * np.hypot(CLOSING_RATE, speed))
    assert np.median(loose.channels["opening"][late] / steady) == pytest.approx(1.0, abs=0.15)
    opened = (step * tight.observables["theta_dot"]) ** 2 / 2
    # of the step before, whose speed differed by up to 50 h, relative
    np.testing.assert_allclose(tight.channels["opening"][1:], opened[1:], rtol=50 * step)


@pytest.mark.parametrize("step", [1e-6, 4e-6])
def test_the_rounding_of_an_opening_is_bounded_and_not_loosely(step):
    found, _ = run("free-large", TIGHT, step, duration=2000 * step)
    error = found.errors["tension"]
    bound = error.model["rounded opening"]
    assert 0.1 * bound < error.predicted.difference < bound
