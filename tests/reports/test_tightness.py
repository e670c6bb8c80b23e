"""How tight tolerances are, and what verdicts would notice, as the page says it."""

import pytest

from plumbob.reports.judge.study_verdicts import judge_study
from plumbob.reports.judge.tightness import Slack, slacks, tightness
from plumbob.reports.view.records import records_of
from plumbob.reports.view.tables import table
from plumbob.reports.view.top_tables import tightness_tables
from plumbob.tests.support.studies import SCENE, quick
from plumbob.tests.validation.tightness import loosest


def slack(used, scale=2.0):
    """A made-up one, that allows 1e-6."""
    return Slack("ode/rk4", SCENE, "theta", 1e-3, 1e-6, used, used < 1e-11, scale, bound_only=False)


def test_what_is_round_off_is_counted_apart():
    every = [slack(1e-12), slack(1e-8), slack(1e-9), slack(1e-8, scale=0.0)]
    (shown,) = tightness(every)
    assert (shown.held, shown.rounded) == (4, 1)
    assert shown.over_use == pytest.approx((100.0, 820.0, 1000.0))
    assert shown.over_scale == pytest.approx((5e-7,) * 3)
    assert loosest(every, 10) == [slack(1e-9)]
    (alone,) = tightness([slack(1e-12, scale=0.0)])
    assert alone.over_use is alone.over_scale is None


def test_predictions_and_bounds_have_tables_of_their_own():
    predicted, bounded = tightness_tables(tightness(slacks(quick(), judge_study(quick()))))
    names = [[cells[0].text for cells in table.rows] for table in (predicted, bounded)]
    assert names == [["mujoco/euler", "ode/leapfrog", "ode/rk4"], ["ode/dop853"]]
    assert all(len(cells) == len(predicted.heads) for cells in predicted.rows)


def test_what_is_noticed_stands_under_its_parameter():
    record = records_of(quick()).scenes[SCENE]
    assert record.exact.sensitivity is not None
    methods = {method.name: method for method in quick().methods}
    noticed = record.exact.sensitivity
    shown = table("sensitivity", noticed=noticed, verdicts=record.verdicts, methods=methods)
    for cells in shown.rows:
        by = {head: cell for head, cell in zip(shown.heads, cells, strict=True)}
        assert by["density"].text == "–"  # the equations do not have it
        assert 0.0 < float(by["gravity"].text) < 1e-5
        assert " at " in by["gravity"].hint
        assert by["theta (from 0)"].text != "–"
