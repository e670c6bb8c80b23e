"""Counts, errors by step and costs on the index, all of them from the stored study."""

import html
import re
from collections import Counter
from dataclasses import replace
from functools import cache

import pytest

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure, relative_error
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.page_numbers import study_record
from plumbob.reports.records import notation
from plumbob.reports.records.page_records import (
    PairVerdict,
    Records,
    RunVerdict,
    SceneRecord,
)
from plumbob.reports.view.method_results import SIGNS, MethodResult, results_of
from plumbob.reports.view.site import first_screen, matrix
from plumbob.reports.view.trimming import trimming_table
from plumbob.tests.site import whole_profile
from plumbob.tests.support.studies import SCENE, quick, verdicts

LINE, DEFAULT = "capsule-line/ca1", "mujoco/euler"


def _about(study, scene):
    return study.quantities(scene)


def _results(study):
    """Every method on every scene, by the study's verdicts, or those of the whole profile."""
    judged = verdicts(whole_profile.study())
    by_scene = {}
    for c in study.convergence:
        by_scene.setdefault(c.scene, {})[c.method] = judged[c.scene, c.method]
    records = {name: SceneRecord(of, (), None) for name, of in by_scene.items()}
    return results_of(study, Records(_record(), records))


@cache
def _record():
    """The record of the whole profile, whatever its numbers are."""
    return study_record(replace(whole_profile.study(), convergence=()), {})


def _matrix(study, scene):
    """The cells of a scene's row, by method."""
    judged = {m: of for (name, m), of in verdicts(study).items() if name == scene.name}
    records = Records(_record(), {scene.name: SceneRecord(judged, (), None)})
    own = tuple(c for c in study.convergence if c.scene == scene.name)
    alone = replace(study, convergence=own)
    every = results_of(alone, records)
    ((_, cells),) = matrix.matrices(alone, every, (scene,))[0].rows
    names = matrix.matrices(alone, every, (scene,))[0].methods
    return {name: cell for name, cell in zip(names, cells, strict=True) if cell}


@pytest.mark.long
def test_counts_of_verdicts_stand_on_the_index(study, index):
    words = " ".join(html.unescape(re.sub(r"<[^>]+>", " ", index.read_text("utf-8"))).split())
    counts = sum(first_screen.meanings_by_engine(_results(study)).values(), Counter())
    for meaning, count in counts.items():
        assert f"{SIGNS[meaning][0]} {count} {SIGNS[meaning][1]}" in words


def _at_steps(study, runs):
    """A study of the line with these relative errors at its end, signed, by step [s]; None for a
    run that diverged."""
    (quantity,) = _about(study, LINE)
    one = next(c for c in study.convergence if (c.scene, c.method) == (LINE, DEFAULT))
    first = next(m for m in one.measurements if m.status == "done")
    measured = [
        replace(first, step=step, status="diverged", errors={})
        if error is None
        else replace(
            first,
            step=step,
            errors={
                **first.errors,
                quantity.observable: replace(
                    first.errors[quantity.observable],
                    end=error * quantity.scale,
                    largest=abs(error) * quantity.scale,
                ),
            },
        )
        for step, error in runs.items()
    ]
    return replace(one, measurements=tuple(measured))


@pytest.mark.parametrize(
    ("runs", "text"),
    [
        ({2e-3: 0.3, 1e-3: 0.1, 5e-4: 0.05}, "10 %"),
        ({2e-3: 0.3, 5e-4: 0.05}, "30 % at 0.002 s"),  # not run at 1 ms
        ({2e-3: 0.3, 1e-3: None, 5e-4: 0.05}, "diverged"),
    ],
)
def test_the_error_at_the_reference_step_or_the_nearest_is_shown(study, runs, text):
    assert _result(study, runs).at_reference.text == text


def _result(study, runs):
    """The default method on the line with these runs, all of them as predicted."""
    runs = _at_steps(study, runs)
    passes = (RunVerdict("predicted", ""),)
    judged = PairVerdict("predicted", "", "as expected", "predicted", "", passes * 4)
    about = _about(study, LINE)
    return MethodResult(find_scene(LINE), find_method(DEFAULT), runs, judged, about)


def test_a_tolerance_stands_beside_an_error_at_it(study):
    cells = _matrix(study, find_scene("cone-pendulum/rotating-base"))
    assert "\nrtol" in cells["ode/dop853"].at_reference.cell(1e-3)


def test_a_cell_has_the_error_at_other_steps(study):
    """At MuJoCo's default step, and at the largest step that is, with all smaller ones, within 1 %:
    one that is so by chance is no answer."""
    for coarse, largest in ((0.3, 2e-3), (0.009, 1e-2)):
        of = _result(study, {1e-2: coarse, 2e-3: 0.009, 1e-3: 0.007, 5e-4: 0.004})
        cells = of.at_reference, of.at_default, of.at_largest
        assert [cell.step for cell in cells] == [1e-3, 2e-3, largest]
        assert of.at_default.cell(2e-3) == "= 0.9 %"
    assert _result(study, {1e-2: 0.3, 2e-3: 0.009, 1e-3: 0.3, 5e-4: 0.03}).at_largest is None


@pytest.mark.long
def test_each_error_is_that_of_a_run_made_again():
    case = case_of(find_scene(SCENE))
    for name, of in _matrix(quick(), case.scene).items():
        for cell in (of.at_reference, of.at_default, of.at_largest):
            again, _ = measure(case, find_method(name), cell.step)
            error = notation.relative(relative_error(again, case.system.quantities(case)))
            assert cell.cell(1e-3)[2:].partition("\n")[0] == error


def test_a_method_has_one_cost_on_a_scene(study):
    cost = study.costs[LINE, DEFAULT]
    costs = {
        pair: replace(cost, ns_per_step=6686.0 if pair[1] == DEFAULT else 9360.0)
        for pair in study.costs
    }
    changed = replace(study, costs=costs)
    scene = next(s for s in study.scenes if s.name == LINE)
    trimmed = trimming_table(changed, scene)
    assert trimmed
    as_run = {row[0].text: row[3].text for row in trimmed.rows}
    step = scene.steps[len(scene.steps) // 2]  # the step of the timing
    assert as_run[DEFAULT] == notation.number(6.686e-3 / step)
