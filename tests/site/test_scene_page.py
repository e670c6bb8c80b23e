"""A scene's page begins with what to expect and what to use, computed from the stored study."""

from math import inf

import pytest

from plumbob.engines.registry import method as find_method
from plumbob.reports.analyses.page_numbers import scene_record
from plumbob.reports.judge.study_verdicts import judge_study
from plumbob.reports.records.page_records import Records, StudyRecord
from plumbob.reports.view.method_results import results_of
from plumbob.reports.view.site.views import RECOMMENDED_ERROR, scene_sentences
from plumbob.reports.view.tables import table
from plumbob.tests.support.studies import SCENE, made_up

STEPS = (2e-3, 1e-3, 5e-4, 2e-4, 1e-4)


def _study(default, rk4):
    """A scene whose relative errors are these functions of the step [s], and on which a step of
    RK4 costs four times one of the default method."""
    methods = [find_method("mujoco/euler"), find_method("mujoco/rk4")]
    both = [(method, STEPS, of) for method, of in zip(methods, (default, rk4), strict=True)]
    return made_up(both, [500.0, 2000.0])


def _parts(study):
    """The record of the scene, and the results of its methods."""
    record = scene_record(study, judge_study(study), study.scenes[0])
    records = Records(StudyRecord((), {}, {}, ()), {SCENE: record})
    return record, list(results_of(study, records).values())


def _sentences(default, rk4):
    record, rows = _parts(_study(default, rk4))
    (answer,) = (
        answer for answer in record.recommendations if answer.error == RECOMMENDED_ERROR
    )
    return scene_sentences(rows, answer)


def test_default_recommended_cost_and_a_smaller_step():
    default, advice = _sentences(lambda h: 20 * h, lambda h: 1e3 * h**2)
    assert default == (
        "MuJoCo's default settings (mujoco/euler): the error is 4 % at 0.002 s. A smaller step "
        "helps: the error is 0.2 % at 1e-4 s; a tenth of the step, 2e-4 s, divides it by 10."
    )
    assert advice == (
        "Recommended for an error of 0.1 %, of the steps that were run: mujoco/rk4 at 0.001 s "
        "(2 ms of computing per simulated second, 500× real time, 8 times the computing time of "
        "the default settings at 2 ms). A smaller step helps: the error is 0.001 % at 1e-4 s; "
        "a tenth of the step, 1e-4 s, divides it by 100."
    )


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (lambda h: 0.04, "does not help: the error is 4 % at 1e-4 s"),
        (lambda h: 0.04 * (h / 2e-3) ** 0.3, "helps little: the error is 1.6 %"),
        (lambda h: 0.04 * (h / 2e-3) ** 0.6, "helps: the error is 0.66 %"),
        (
            lambda h: inf if h > 1e-4 else 0.04,
            "the run diverges at 0.002 s. A smaller step helps",
        ),
    ],
)
def test_whether_a_smaller_step_helps_is_measured(error, words):
    default, *_ = _sentences(error, lambda h: h**2)
    assert words in default


def test_each_method_has_its_error_its_verdict_with_a_reason_and_its_cost():
    record, results = _parts(_study(lambda h: 20 * h, lambda h: 0.3))
    shown = table("scene_errors", rows=results)
    assert shown.heads == (
        "method",
        "at the end; order (theory's)",
        "largest on the way; order (theory's)",
        "verdict",
        "computing [ms per simulated s]",
        "× real time",
    )
    rows = {cells[0].text: cells for cells in shown.rows}
    for name, error, cost, speed in (
        ("mujoco/euler", "2 %\n1.00 (1.00)", "0.5", "2000×"),
        ("mujoco/rk4", "30 %\n0.00 (0.00)", "2", "500×"),
    ):
        _, at_end, on_the_way, verdict, time, factor = rows[name]
        assert (at_end.text, on_the_way.text) == (error, error)
        assert (time.text, factor.text) == (cost, speed)
        judged = record.verdicts[name]
        assert judged.verdict in verdict.kind.split()
        assert (
            verdict.hint == "as above"
            if name == "mujoco/rk4"
            else judged.reason in verdict.hint
        )
