"""The experiment for a bench: its uncertainty by 30 digits, what MuJoCo sees, its plan."""

import json

import mpmath as mp
import pytest

from plumbob.reports.analyses.capsule_line import experiment
from plumbob.reports.analyses.capsule_line.experiment import BENCH_UNCERTAINTIES, SET
from plumbob.reports.cli import main
from plumbob.tests.support.declared import finding, nothing

AT = {"friction": 0.3, "body_mass": 1.0, "slider_mass": 0.3, **SET}


@pytest.fixture(name="bench", scope="module")
def _bench():
    return experiment.numbers()


def displacement(friction, body_mass, slider_mass, w1, w2, t1):
    """Eq. 22 of Chernousko 2020."""
    mu = slider_mass / (body_mass + slider_mass)
    hold = friction * mp.mpf("9.81")
    return -mu * (w1 + w2) * (mu * w1 - hold) / (mu * w2 + hold) * t1**2 / 2


def test_each_part_of_the_uncertainty_is_the_formula_s(bench):
    with mp.workdps(30):
        values = [mp.mpf(str(value)) for value in AT.values()]
        total = mp.mpf(0)
        for number, row in enumerate(bench.usual.rows):
            assert row.name == list(AT)[number]
            assert row.amount == AT[row.name]
            order = tuple(int(number == k) for k in range(len(AT)))
            slope = mp.diff(displacement, tuple(values), order)
            assert row.slope == pytest.approx(float(slope), rel=1e-9)
            total += (slope * BENCH_UNCERTAINTIES[row.name]) ** 2
        assert bench.usual.unsure == pytest.approx(float(mp.sqrt(total)), rel=1e-9)
        assert bench.usual.displacement == pytest.approx(
            float(displacement(*values)), rel=1e-14
        )


def test_the_command_says_where_the_plan_ends(bench, capsys):
    words = next(c for c in finding(experiment.EXPERIMENT, nothing()).commands if "--on" in c)
    assert main([*words.split()[1:], "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["on"]["position_error"] == pytest.approx(bench.plan.away, rel=1e-9)
    assert answer["on"]["heading_error"] == pytest.approx(bench.plan.turned, rel=1e-9)
    assert answer["position_error"] < 1e-12
    assert main([*words.split()[1:-1], "mass=3"]) == 2
    assert capsys.readouterr().err.startswith("plumbob: mass = 3: must be")
