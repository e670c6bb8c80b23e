"""pymunk's simple pendulum against the exact motion and the theory of its joint."""

from dataclasses import replace

import pytest

from plumbob.engines.adapters.pymunk import ENGINE
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene

METHODS = {m.name: m for m in ENGINE.methods if "simple-pendulum" in m.systems}
TIGHT = METHODS["pymunk/tight"]


def run(name, method, step, duration, **settings):
    """One run of a scene of the simple pendulum, cut to `duration` [s]."""
    scene = replace(find_scene(f"simple-pendulum/{name}"), duration=duration)
    how = replace(method, settings={**method.settings, **settings})
    found, trajectory = measure(case_of(scene), how, step)
    assert trajectory is not None
    return found, trajectory


@pytest.mark.parametrize("step", [1e-6, 4e-6])
def test_the_rounding_of_an_opening_is_bounded_and_not_loosely(step):
    found, _ = run("free-large", TIGHT, step, duration=2000 * step)
    error = found.errors["tension"]
    bound = error.model["rounded opening"]
    assert 0.1 * bound < error.predicted.difference < bound
