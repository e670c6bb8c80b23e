"""The capsule in engines beside MuJoCo and pymunk: known errors, and what a small defect does."""

from dataclasses import replace

import pytest

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure, relative_error
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.tests.peers.test_smooth_peers import needed

BEST = ("dart/nsgs", "drake/tamsi+stiction")


@pytest.mark.parametrize("name", BEST)
@pytest.mark.parametrize("change", [{"friction": 0.9}, {"gravity": 1.01}])
def test_a_small_defect_is_an_error_that_no_step_reduces(name, change):
    needed(name)
    scene = find_scene("capsule-line/heading-030")
    case = case_of(scene)
    method = find_method(name)
    wrong = {n: factor * scene.parameters[n] for n, factor in change.items()}
    system = case.system
    broken = replace(case, problem=system.problem(system.change(scene.parameters, wrong)))
    errors = [
        relative_error(measure(broken, method, h)[0], system.quantities(case))
        for h in (1e-3, 5e-4)
    ]
    assert errors[1] > 0.7 * errors[0] > 1e-3


@pytest.mark.parametrize("name", BEST)
def test_one_step_late_at_a_sample_is_seen(name):
    """The slider's motion is prescribed: at every sample it is where it is to be."""
    needed(name)
    scene = find_scene("capsule-line/heading-030")
    step = 1e-3
    case = case_of(scene)
    _, run = measure(case, find_method(name), step)
    exact = case.reference.observe(run.times)["stroke_rate"]
    late = case.reference.observe(run.times - step)["stroke_rate"]
    off = abs(run.observables["stroke_rate"] - exact).max()
    assert off < 1e-6 < 1e-2 < abs(run.observables["stroke_rate"] - late).max()
