"""Every scene with every method, at all its step sizes, is as expected: `plumbob validate` as a
test, with the same options: pytest tests/validation --profile full --scenes GLOB --methods GLOB;
`make test` takes those that stand for the rest."""

import os

import pytest

from plumbob.engines.registry import methods
from plumbob.engines.study.runner import pairs
from plumbob.models.registry import case_of, scenes, system_of
from plumbob.reports.judge.expectations import expected, surprise
from plumbob.reports.judge.verdict import judge_method
from plumbob.tests.validation.representatives import representatives


def pytest_generate_tests(metafunc):
    """One test for each pair that the options choose."""
    if "method" not in metafunc.fixturenames:
        return
    option = metafunc.config.getoption
    chosen = pairs(scenes(option("scenes"), option("profile")), methods(option("methods")))
    if option("suite") == "short":
        chosen = representatives(chosen)
    names = [f"{scene.name}-{method.name}" for scene, method in chosen]
    metafunc.parametrize(("scene", "method"), chosen, ids=names)


def test_verdict(scene, method, shared, pytestconfig):
    option = pytestconfig.getoption
    found = shared.convergence(scene, method, option("profile"), option("seed"))
    about = system_of(scene).quantities(case_of(scene))
    judgement = judge_method(found, system_of(scene), method, about).whole
    if judgement.verdict == "missing" and not os.environ.get("CI"):
        pytest.skip(judgement.reason)
    assert judgement.reason or judgement.verdict != "unsupported"
    why = surprise(scene, method, judgement)
    assert not why, f"{why} ({judgement.reason}) {expected(scene.name, method.name).reason}"
