"""What the page says of the free body is so; the commands solve it and refuse what is no body."""

import json

import pytest

from plumbob.engines.registry import method
from plumbob.engines.study.convergence import convergence_study
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene
from plumbob.reports.analyses.free_body import second_order
from plumbob.reports.cli import main
from plumbob.tests.support.declared import nothing

FLIP, STEPS = scene("free-body/flip"), (3.2e-2, 1.6e-2, 8e-3, 4e-3, 2e-3, 1e-3)


def study(*names):
    """A study of the scene that turns over, with these methods."""
    chosen = tuple(method(name) for name in names)
    found = tuple(convergence_study(FLIP, how, 25_000, STEPS) for how in chosen)
    empty = nothing()
    return Study(empty.profile, (FLIP,), chosen, found, {}, 1.0, dict(empty.seconds))


@pytest.mark.long
def test_mujoco_s_rk4_against_the_classical_one():
    found = second_order(study("mujoco/rk4", "ode/rk4"))
    mujoco, classical = found.runs
    assert mujoco.error == pytest.approx(mujoco.term, rel=0.01)
    assert [run.order.slope for run in found.runs if run.order] == pytest.approx(
        [2.0, 4.0], abs=0.05
    )
    assert classical.term == 0.0
    assert classical.error < 1e-4 * mujoco.error
    assert mujoco.error == pytest.approx(8.9e-7, rel=0.01)


def test_solve_in_words_and_in_json(capsys):
    assert main(["solve", "free-body", "--times", "1,5", "--set", "angular_velocity=[1,2,3]"]) == 0
    assert "attitude_w" in capsys.readouterr().out
    assert main(["solve", "free-body/symmetric", "--times", "1", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    text = json.dumps(found)
    assert "angular_velocity_x" in text
    assert '"kind"' in text
    assert "half_period" in text
