"""Digits that hard cases lose: of the motion, and of methods beside it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from plumbob.models.registry import scene as find_scene
from plumbob.reports.view import hard_cases
from plumbob.tests.support.studies import quick

SADDLE = "cone-pendulum/above-barrier-1e-6"


def test_digits_are_counted_from_a_rounding() -> None:
    assert hard_cases.digits_lost(2.0**-53) == 0.0
    assert hard_cases.digits_lost(0.0) == 0.0
    assert hard_cases.digits_lost(1.0) == pytest.approx(15.95, abs=0.01)


def test_a_saddle_at_1e_6_costs_the_motion_about_eight_digits_and_a_fast_platform_three() -> None:
    """6 for the distance, and two for the way there and back; 81 rad in all for the platform."""
    assert hard_cases.lost_by_motion(quick(), find_scene(SADDLE)) == pytest.approx(7.9, abs=0.2)
    platform = hard_cases.lost_by_motion(quick(), find_scene("cone-pendulum/fast-platform"))
    assert platform is not None
    assert platform < 5.0


def test_the_tables_name_every_hard_scene_and_every_method() -> None:
    study = quick()
    table = hard_cases.of_system(study, study.scenes, {})
    assert table is not None
    assert len(table.rows) == sum(bool(scene.hard) for scene in study.scenes)
    methods = hard_cases.of_scene(study, find_scene(SADDLE))
    assert methods is not None
    steps = {row[0].text: row[-1].text for row in methods.rows}
    assert set(steps) == {method.name for method in study.methods}
    assert steps["mujoco/euler"] == "none run"
    assert "rtol" in steps["ode/dop853"]


def test_a_study_without_runs_says_nothing() -> None:
    empty = replace(quick(), convergence=())
    assert hard_cases.lost_by_motion(empty, find_scene(SADDLE)) is None
    assert hard_cases.of_scene(empty, find_scene(SADDLE)) is None
