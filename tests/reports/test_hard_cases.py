"""Digits that hard cases lose: of the motion, and of methods beside it."""

from dataclasses import replace

import pytest

from plumbob.analytic.stability import StepLimit
from plumbob.engines.study.stability import PredictedLimits, StepPrediction
from plumbob.models.registry import scene as find_scene
from plumbob.reports.view import hard_cases
from plumbob.reports.view.site import largest_step as of_index
from plumbob.reports.view.step_ranges import step_ranges
from plumbob.tests.support.studies import quick

SADDLE = "cone-pendulum/above-barrier-1e-6"
SWING, EULER = "cone-pendulum/equal-wells-short", "mujoco/euler"


def cases(study, scenes):
    """The table of hard cases of scenes of a study."""
    return hard_cases.table(study, [(scene, step_ranges(study, scene)) for scene in scenes])


def test_a_saddle_at_1e_6_costs_the_motion_about_eight_digits_and_a_fast_platform_three():
    """6 for the distance, and two for the way there and back; 81 rad in all for the platform."""
    assert hard_cases.lost_by_motion(quick(), find_scene(SADDLE)) == pytest.approx(7.9, abs=0.2)
    platform = hard_cases.lost_by_motion(quick(), find_scene("cone-pendulum/fast-platform"))
    assert platform
    assert platform < 5.0


def test_one_table_names_every_hard_scene_with_every_method_that_ran_it():
    """A system's page has the same rows as the pages of its scenes, below a row that names the
    scene and what makes it hard; where no limit is stored, columns on stability are left out."""
    study = quick()
    hard = [scene for scene in study.scenes if scene.hard]
    table, alone = (cases(study, of) for of in (hard, [find_scene(SADDLE)]))
    assert (*table.heads[:3], table.heads[-1]) == alone.heads
    names = [row[0].text for row in table.rows]
    assert [name for name in names if "/" in name and name.startswith("cone-")] == [
        scene.name for scene in hard
    ]
    place = names.index(SADDLE)
    assert table.rows[place][1].text.startswith(find_scene(SADDLE).hard)
    assert "loses 7.9 of the 16 digits" in table.rows[place][1].text
    rows = table.rows[place + 1 : place + 1 + len(alone.rows)]
    assert tuple((*row[:3], row[-1]) for row in rows) == alone.rows
    steps = {row[0].text: row[2].text for row in alone.rows}
    assert set(steps) == {method.name for method in study.methods}
    assert steps["mujoco/euler"] == "none run"
    assert "rtol" in steps["ode/dop853"]


@pytest.mark.parametrize("step", [0.1, 0.4])
def test_the_first_screen_says_the_stored_limit(step, monkeypatch):
    monkeypatch.setattr(of_index, "SCENES", (SWING,))
    assert of_index.largest_step(replace(quick(), extras={})) is None
    prediction = PredictedLimits((StepLimit("unstable", step, "chosen"),))
    study = replace(quick(), extras={StepPrediction(SWING, EULER): prediction})
    shown = of_index.largest_step(study)
    assert shown.default.text == f"within 1 % up to 0.002 s, stable up to {step} s (predicted)"
    assert f"{step:g}; 0.002" in [cell.text for cell in shown.table.rows[0]]
