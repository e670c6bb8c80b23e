"""Digits that hard cases lose: of the motion, and of methods beside it."""

import pytest

from plumbob.models.registry import scene as find_scene
from plumbob.reports.view import hard_cases
from plumbob.reports.view.step_ranges import step_ranges
from plumbob.tests.support.studies import quick

SADDLE = "cone-pendulum/above-barrier-1e-6"


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
