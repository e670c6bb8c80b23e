"""An engine whose scheme no theory covers converges where it reads a scene as it is, and not where
it reads gravity or friction wrongly."""

import pytest

from plumbob.engines import registry
from plumbob.engines.study.convergence import convergence_study
from plumbob.engines.study.runner import most_steps
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.judge.verdict import judge_method
from plumbob.tests.commands.outcomes import misread, without_theory

SWING, LINE = "simple-pendulum/free-large", "capsule-line/heading-030"


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    ("scene", "method", "factors", "converges"),
    [
        (SWING, "mujoco/euler", {}, True),
        (SWING, "mujoco/euler", {"gravity": 1.01}, False),
        (SWING, "mujoco/euler", {"gravity": 1.0 + 1e-4}, False),
        (LINE, "mujoco/euler+coulomb", {}, True),
        (LINE, "mujoco/euler+coulomb", {"gravity": 1.01}, False),
        (LINE, "mujoco/euler+coulomb", {"friction": 0.9}, False),
    ],
)
def test_an_engine_without_theory(scene, method, factors, converges, monkeypatch):
    chosen = find_scene(scene)
    how = registry.method(method)
    assert set(factors) <= set(chosen.parameters)
    without_theory(monkeypatch)
    if factors:
        misread(monkeypatch, "mujoco", factors)
    case = case_of(chosen)
    found = convergence_study(chosen, how, most_steps(chosen, "quick"))
    verdict = judge_method(found, case.system, how, case.system.quantities(case)).whole.verdict
    assert (verdict == "converges") == converges, verdict
