"""The capsule in pymunk: on feet and from the side errors are as predicted, on bare pivots they are
not."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.adapters.pymunk import capsule
from plumbob.tests.support.cases import beyond
from plumbob.tests.support.pymunk_capsule import (
    GOOD,
    METHODS,
    last,
    moved,
    problem_of,
    run,
)
from plumbob.tests.support.random_capsules import LINE


@pytest.mark.parametrize("model", GOOD)
def test_model_error_bounds_are_small(model):
    # Less than the sawtooth's largest value, so that a fault of the size of the step's error is
    # detected: 50 iterations with one sticking foot leave 2 % of the velocity change at the stop,
    # contacts leave nothing.
    part = {"feet": 0.6, "side": 1e-3}[model]
    for step in (1e-3, 1e-4):
        bounds = capsule.model_error(problem_of(LINE), 0.15, METHODS[model], step)
        assert sum(bounds["displacement"].values()) < part * LINE.closed.braking * step**2 / 8


@pytest.mark.long
def test_every_heading_alike():
    # The force limit of a joint is a disc, so that headings differ by rounding only; required:
    # 1e-12.
    for step in (1e-3, 5e-4):
        ends = [last(f"capsule-line/heading-{a:03d}", "feet", step) for a in range(0, 360, 15)]
        assert np.ptp(ends) < 1e-12 * abs(ends[0])


@pytest.mark.parametrize("iterations", [10, 300])
def test_bare_pivots_do_not_converge(iterations, monkeypatch):
    # an error of 7.2 % along this line, at any step and number of iterations
    line, method = replace(LINE, direction=math.radians(50)), METHODS["pivots"]
    tried = replace(method, settings={**method.settings, "iterations": iterations})
    monkeypatch.setitem(METHODS, "pivots", tried)
    for step in (1e-3, 2e-4):
        seen = moved(line, "pivots", step)["displacement"]
        assert seen == pytest.approx(1.072 * line.displacement, rel=1e-3)


def test_drift_in_ten_seconds():
    # Required: 1e-6 m at 0.999 of the threshold; pivots slide away.
    for model, most in (("feet", 1e-15), ("side", 1e-15)):
        assert abs(last("capsule-hold/0.999", model, 1e-3)) < most
    assert last("capsule-hold/0.999", "pivots", 1e-3) > 1.0


def test_normal_forces_from_the_side():
    # at rest those of the contacts are those of statics to 1e-6 or better: the solver's residual
    loads = [f"normal_force_{i}" for i in (1, 2, 3)]
    found, _ = run("capsule-hold/0.5", "side", 1e-3)
    assert all(found.errors[n].largest < 1e-9 * found.errors[n].scale for n in loads)
    # While the slider moves, those of its actual place, half a step behind its target: the only
    # difference is rounding over dt^2 (at zero heights its acceleration shifts no load).
    for step in (1e-3, 1e-4):
        found, trajectory = run("capsule-line/at-50", "side", step)
        # only contacts and gravity change the momentum, up to its rounding over a step
        assert np.abs(trajectory.channels["momentum_residual"]).max() < 1e-15 / step
        for error in (found.errors[name] for name in loads):
            assert beyond(error) < 1e-8 * error.scale
            assert error.predicted.largest > 100 * beyond(error)
