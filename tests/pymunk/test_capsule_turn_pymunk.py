"""Turns, spins and plans in pymunk: feet as predicted, small mistakes fail, bare pivots do not
converge."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.cases import beyond
from plumbob.tests.support.pymunk_capsule import METHODS, run, verdict

CASES = (  # scene, steps in a half time (or a step [s]), part of the error that the model may add
    ("capsule-turn/0.3", 200, 0.02),
    ("capsule-turn/0.1-stop", 100, 0.03),
    ("capsule-turn/0.001", 50, 0.05),
    ("capsule-turn/unloaded", 100, 0.03),
    ("capsule-turn/pivot", 200, 0.2),
    ("capsule-turn/held", 200, 1.0),
    ("capsule-coast/spin", 5e-4, 0.03),
    ("capsule-plan/near-free", 1e-3, 0.03),
)


def step_of(name, parts):
    """`parts` of a scene's half time, or the step itself."""
    return scene(name).parameters["half_time"] / parts if parts > 1 else parts


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(("name", "parts", "part"), CASES)
def test_the_error_of_feet_is_as_predicted(name, parts, part):
    """Within the error of the step plus the model-error bound, which is much smaller (except where
    a growing load overcomes friction, and iterations stall)."""
    found, _ = run(name, "feet", step_of(name, parts))
    assert verdict(found, "feet") == "predicted"
    leading = next(iter(found.errors.values()))
    assert sum(leading.model.values()) <= part * leading.predicted.largest
    assert leading.largest == pytest.approx(leading.predicted.largest, rel=part)


@pytest.mark.long
@pytest.mark.parametrize("which", [min, max], ids=["shorter slide", "longer slide"])
@pytest.mark.parametrize(("late", "least", "most"), [(0.5, 0.0, 1e-10), (0.9987, 1e-7, 1.0)])
def test_a_switch_at_the_very_end_of_a_step(late, least, most, which):
    """A push that begins in the last thousandth of a step sets the body off by the solver's
    residual, which persists while it slides: the bound covers that, and for the longest slide less
    than 2.5 times as much. Rounding decides which of a plan's two pushes is the first."""
    short, how = scene("capsule-plan/ahead-curve", {"to": (0.02, 0.0, 0.0)}), METHODS["feet"]
    problem = case_of(short).problem
    events = problem.reference.motion.events
    slides = [(b.time - a.time, a.time) for a, b in pairwise(events) if a.mode == "slide"]
    lasts, starts = which(slides)
    step = starts / (round(starts / 5e-5) + late)
    case = case_of(short).lasting(step * math.ceil(problem.motion.duration / step + 1))
    found, _ = measure(case, how, step)
    assert verdict(found, "feet") == "predicted"
    place = found.errors["x"]
    assert least <= beyond(place) <= most
    bound = sum(place.model.values()) * lasts / max(slides)[0]
    assert least == 0.0 or bound < 2.5 * beyond(place)
