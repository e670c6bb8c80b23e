"""The first screen says which settings to use, what they cost and what they give, all of it from
the stored study."""

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
from plumbob.tests.support.studies import SCENE, quick, remeasured, verdicts

LINE, DEFAULT, CONVERGENT, RK4 = "capsule-line/ca1", *first_screen.KINDS[0].methods


def _with_error(study, scene, method, error):
    """The study with another relative error of the displacement in every run of a pair, or with
    one that is a function of the step [s]."""
    at = error if callable(error) else lambda step: error
    (quantity,) = _about(study, scene)

    def changed(m):
        if (m.scene, m.method) != (scene, method):
            return m
        size = at(m.step) * quantity.scale
        own = m.errors[quantity.observable]
        own = replace(own, largest=size, end=size)
        return replace(m, errors={**m.errors, quantity.observable: own})

    return remeasured(study, changed)


def _about(study, scene):
    return study.quantities(scene)


def _answers(study):
    return first_screen.recommended_settings(study, _record(), _results(study))


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


def _said(study):
    contacts, joints = _answers(study)
    assert (contacts.name, joints.name) == ("with-contacts", "without-contacts")
    return " ".join(contacts.sentences)


@pytest.mark.long
def test_settings_costs_and_results_stand_on_the_index(study, index):
    text = index.read_text("utf-8")
    first = html.unescape(re.sub(r"<[^>]+>", " ", text.partition('id="findings"')[0]))
    words = " ".join(first.split())
    contacts = _answers(study)[0]
    assert all(sentence in words for sentence in contacts.sentences)
    for settings in ('cone="elliptic"', 'solreffriction="-1 -0.1"', 'integrator="RK4"'):
        assert settings in words
    for said in ("A step takes", "plumbob settings", "runs."):
        assert said in words
    counts = sum(first_screen.meanings_by_engine(_results(study)).values(), Counter())
    for meaning, count in counts.items():
        assert f"{SIGNS[meaning][0]} {count} {SIGNS[meaning][1]}" in words


def test_the_answer_is_computed_from_the_study(study):
    for error, said in ((0.0123, "1.2 %"), (4.5e-5, "0.0045 %")):
        changed = study
        for scene in (s.name for s in study.scenes if s.system == "capsule-line"):
            changed = _with_error(changed, scene, CONVERGENT, error)
        assert f"stops with an error of {said}" in _said(changed)
    assert "39 %" in _said(_with_error(study, LINE, DEFAULT, 0.39))


def test_an_error_that_crosses_zero_is_the_largest_at_smaller_steps(study):
    """An error of h - 1 ms is zero at 1 ms, and nearly 1e-3 at the smallest step."""
    changed = study
    for scene in (s.name for s in study.scenes if s.system == "capsule-line"):
        changed = _with_error(changed, scene, CONVERGENT, lambda step: abs(step - 1e-3) + 1e-9)
    said = re.search(r"stops with an error of (\S+) %", _said(changed))
    pair = LINE, CONVERGENT
    series = next(c for c in study.convergence if (c.scene, c.method) == pair)
    steps = [run.step for run in series.measurements]
    # Two digits are printed, the first of which is 9: 1.1 % of a rounding error at most.
    assert float(said[1]) == pytest.approx(100 * (1e-3 - min(steps)), rel=0.011)


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
    (contacts, _) = _answers(changed)
    assert all("1.4 times" in s.cost for s in contacts.pasted.settings.snippets)
    scene = next(s for s in study.scenes if s.name == LINE)
    trimmed = trimming_table(changed, scene)
    assert trimmed
    as_run = {row[0].text: row[3].text for row in trimmed.rows}
    step = scene.steps[len(scene.steps) // 2]  # the step of the timing
    assert as_run[DEFAULT] == notation.number(6.686e-3 / step)
