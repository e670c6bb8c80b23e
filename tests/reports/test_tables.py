"""The tables of a scene show what they say: the finest run, and the predicted beside the observed
order."""

from __future__ import annotations

from dataclasses import replace

import pytest

from plumbob.engines.study.order import Order
from plumbob.models.registry import system_of
from plumbob.reports.judge.verdict import judge_study, judged
from plumbob.reports.view import notation, tables
from plumbob.reports.view.content import Table
from plumbob.tests.support.studies import SCENE, quick

FOUND = [c for c in quick().convergence if c.scene == SCENE]
METHODS = {m.name: m for m in quick().methods}


def texts(table: Table | None) -> dict[str, list[str]]:
    """The cells of a table by their head, a list each."""
    assert table is not None
    rows = [[cell.text for cell in row] for row in table.rows]
    columns = list(zip(*rows, strict=True))
    return {head: list(column) for head, column in zip(table.heads, columns, strict=True)}


@pytest.mark.parametrize(
    ("value", "text"),
    [(1.5, "1.5 s"), (2.5e-3, "2.5 ms"), (1e-3, "1 ms"), (320e-6, "320 µs"), (5e-6, "5 µs"),
     (9.9e-7, "990 ns")],
)  # fmt: skip
def test_a_time_has_the_unit_that_suits_it(value: float, text: str) -> None:
    assert notation.seconds(value) == text


def test_a_real_time_factor_is_simulated_over_computing_time() -> None:
    assert notation.real_time_factor(1e9) == "1"
    assert notation.times_real(2e6) == "500×"  # 2 ms of computing for a simulated second
    assert notation.times_real(4e9) == "0.25×"
    assert notation.times_real(0.0) == "–"


def test_the_summary_shows_the_finest_run() -> None:
    verdicts = {
        method: both for (scene, method), both in judge_study(quick()).items() if scene == SCENE
    }
    (scene,) = [s for s in quick().scenes if s.name == SCENE]
    shown = texts(tables.summary(system_of(scene), FOUND, verdicts, METHODS))
    for i, c in enumerate(FOUND):
        coarsest, finest = (
            notation.step(c.measurements[k].step, METHODS[c.method].control) for k in (0, -1)
        )
        assert shown["finest step"][i] == finest != coarsest
        error = notation.number(c.measurements[-1].errors["theta"].largest)
        assert shown["error of theta [rad]"][i] == error


def test_predicted_and_observed_orders_stand_in_their_columns() -> None:
    (rk4,) = [c for c in FOUND if c.method == "ode/rk4"]
    steps = rk4.measurements[0].step, rk4.measurements[1].step
    order, predicted = Order(3.5, 3.4, 3.6, steps), Order(2.5, 2.4, 2.6, steps)
    shown = texts(tables.orders([replace(rk4, order=order, predicted_order=predicted)], METHODS))
    assert shown["observed [95 % interval]"][0].startswith("3.5")
    assert shown["predicted here"][0].startswith("2.5")


def test_a_run_off_its_prediction_is_shown_as_such() -> None:
    """The sum of the budget bounds the error; an error that is too small exceeds none of it."""
    (euler,) = [c for c in FOUND if c.method == "mujoco/euler"]
    finest = euler.measurements[-1]
    error = finest.errors["theta"]
    assert error.predicted is not None
    off = replace(error.predicted, difference=error.largest, beyond=error.largest)
    errors = {**finest.errors, "theta": replace(error, largest=0.0, end=0.0, predicted=off)}
    wrong = replace(euler, measurements=(*euler.measurements[:-1], replace(finest, errors=errors)))
    (scene,) = [s for s in quick().scenes if s.name == SCENE]
    system, method = system_of(scene), METHODS["mujoco/euler"]
    found = {"mujoco/euler": judged(wrong, system, method)}
    assert found["mujoco/euler"].whole.verdict == "fail"
    shown = texts(tables.budgets(system, [wrong], found, METHODS))
    assert "the sum: within, but EXCEEDED" in "; ".join(shown["reason"] + shown["term"])
    hints = [cell.hint for cell in tables.every_run(system, [wrong], found, METHODS).rows[0]]
    assert f"{notation.number(error.largest)} off its prediction, allowed" in hints[-1]
