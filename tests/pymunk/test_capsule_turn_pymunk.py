"""Turns, spins and plans in pymunk: feet as predicted, small mistakes fail, bare pivots do not
converge."""

import math
from itertools import pairwise

import pytest

from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.cases import beyond
from plumbob.tests.support.pymunk_capsule import METHODS, verdict


@pytest.mark.long
@pytest.mark.parametrize("which", [min, max], ids=["shorter slide", "longer slide"])
@pytest.mark.parametrize(("late", "least", "most"), [(0.5, 0.0, 1e-10), (0.9987, 1e-7, 1.0)])
def test_a_switch_at_the_very_end_of_a_step(late, least, most, which):
    """A push that begins in the last thousandth of a step sets the body off by the solver's
    residual, which persists while it slides: the bound covers that, and for the longest slide less
    than 2.5 times as much. Rounding decides which of a plan's two pushes is the first."""
    short = scene("capsule-plan/ahead-curve", {"to": (0.02, 0.0, 0.0)})
    how = METHODS["feet"]
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
