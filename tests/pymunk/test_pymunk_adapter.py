"""pymunk's simple pendulum against the exact motion and the theory of its joint."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.adapters.pymunk import ENGINE, prepare
from plumbob.engines.adapters.pymunk.methods import CLOSING_RATE
from plumbob.engines.method import Unsupported
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, system_of
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


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("iterations", [2, 50])
def test_iterations_change_nothing(name, iterations):
    # One joint is solved exactly in one iteration, apart from the digits lost by the small moment
    # of inertia of the bob.
    _, ten = run("free-large", METHODS[name], 1e-3, duration=2.0)
    _, other = run("free-large", METHODS[name], 1e-3, duration=2.0, iterations=iterations)
    np.testing.assert_allclose(
        other.observables["theta"], ten.observables["theta"], rtol=0, atol=1e-12
    )


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


@pytest.mark.parametrize("iterations", [1, 10])
def test_a_bob_that_flies_off_is_a_result(iterations, monkeypatch):
    # with a moment of 1e-12 m L^2 the joint's equations lose twelve digits
    monkeypatch.setattr("plumbob.engines.adapters.pymunk.simple_pendulum.MOMENT", 1e-12)
    found, trajectory = run("free-small", TIGHT, 1e-3, duration=5.0, iterations=iterations)
    assert found.status == ("diverged" if iterations == 1 else "done")
    for values in trajectory.observables.values():
        assert np.isfinite(values).all()
        assert len(values) == len(trajectory.times)


def test_a_scene_without_a_builder_is_unsupported():
    scene = find_scene("cone-pendulum")
    case = replace(system_of(scene), family="top").case(scene)
    with pytest.raises(Unsupported, match="no builder for cone-pendulum"):
        prepare(case, TIGHT, 1e-3)
