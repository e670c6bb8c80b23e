"""The shipped numbers of findings on policies in the loop are those that runs give now."""

import numpy as np
import pytest

from plumbob.engines.study.codec import from_json
from plumbob.reports.records.exact_numbers import ExactNumbers, exact_numbers_of
from plumbob.tests.validation.exact_numbers import text_of
from plumbob.tests.validation.loop_findings import COMPUTED, computed_now
from plumbob.tests.validation.trained_policies import FOLDER, TASKS


def recomputed(template):
    """The numbers that are shipped, and those of now, written and read again."""
    now = from_json(text_of(computed_now(template)), ExactNumbers)
    return exact_numbers_of(template).numbers, now.numbers


@pytest.mark.rare
def test_the_intervals_of_the_cart_pole():
    shipped, now = recomputed("engines/cart_pole_loop")
    assert now["continuous"] == pytest.approx(shipped["continuous"], rel=1e-9)
    for old, new in zip(shipped["loops"], now["loops"], strict=True):
        assert all(new["measured"].values())
        for before, after in zip(old["intervals"], new["intervals"], strict=True):
            # Holds and delays are whole steps; a factor is bisected to a thousandth.
            assert after["high"]["value"] == pytest.approx(before["high"]["value"], rel=1e-3)
            assert after["high"]["confirmed"]


@pytest.mark.rare
@pytest.mark.parametrize("template", ["engines/cheetah_rhythm", "engines/trained_policies"])
def test_mean_returns_are_within_their_intervals(template):
    """On another processor chaotic runs part: the means then differ by what the intervals say."""
    pytest.importorskip("gymnasium")
    shipped, now = recomputed(template)
    pairs = list(zip(_rows(shipped), _rows(now), strict=True))
    assert len(pairs) >= 10
    for old, new in pairs:
        assert abs(old["mean"] - new["mean"]) <= np.hypot(old["half"], new["half"]), old


def _rows(numbers):
    """All rows of mean returns among numbers."""
    if "tasks" in numbers:
        return [row for of in numbers["tasks"].values() for row in (*of["rows"], *of["again"])]
    return [row for rows in numbers["rows"].values() for row in rows]


def test_each_finding_has_its_numbers_and_each_task_its_weights():
    for template in COMPUTED:
        assert exact_numbers_of(template).versions["mujoco"]
    for task in TASKS:
        assert np.isfinite(np.loadtxt(FOLDER / f"{task}.txt")).all()
    # Two estimates of what the step changes, from other seeds, differ by less than a fifth of the
    # return, and by no more than chance.
    for of in exact_numbers_of("engines/trained_policies").numbers["tasks"].values():
        low, high = of["apart"]
        assert low <= 0.0 <= high
        assert high - low < abs(of["rows"][0]["mean"]) / 5.0
