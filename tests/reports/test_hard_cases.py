"""Digits that hard cases lose: of the motion, and of methods beside it."""

import pytest

from plumbob.models.registry import scene as find_scene
from plumbob.reports.view import hard_cases
from plumbob.reports.view.method_results import MethodResult
from plumbob.tests.support.studies import quick

SADDLE = "cone-pendulum/above-barrier-1e-6"


def test_a_saddle_at_1e_6_costs_the_motion_about_eight_digits_and_a_fast_platform_three():
    """6 for the distance, and two for the way there and back; 81 rad in all for the platform."""
    assert hard_cases.lost_by_motion(_results(SADDLE)) == pytest.approx(7.9, abs=0.2)
    platform = hard_cases.lost_by_motion(_results("cone-pendulum/fast-platform"))
    assert platform
    assert platform < 5.0


def test_an_error_beyond_the_motion_loses_all_digits_of_a_double_and_no_more():
    lost = [hard_cases.digits_lost(size) for size in (0.0, 2.0**-53, 1e-6, 1.0, 41e3)]
    assert lost == pytest.approx([0.0, 0.0, 9.95, 15.95, 15.95], abs=0.01)


def _results(name):
    """The methods of the quick profile on a scene."""
    study = quick()
    scene = find_scene(name)
    methods = {method.name: method for method in study.methods}
    return [
        MethodResult(scene, methods[c.method], c, None, study.quantities(name))
        for c in study.convergence
        if c.scene == name
    ]
