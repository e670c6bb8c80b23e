"""Small mistakes fail the verdict, in every system and for every kind of exact answer: a run passes
when it is held to its own scene, and fails when one parameter of that is a little different."""

import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from plumbob.engines.method import meant
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.registry import methods as find_methods
from plumbob.models.registry import case_of, scene
from plumbob.reports.judge.verdict import judge
from plumbob.tests.support.cases import run_of
from plumbob.tests.support.random_capsules import CHECK
from plumbob.tests.support.random_slides import moved_support

SUPPORTS = {  # other values of them
    "moved": moved_support(CHECK, 1e-4).supports,
    "swapped": tuple(CHECK.supports[i] for i in (0, 2, 1)),
}
WRONG = tomllib.loads(Path(__file__).with_name("wrong_parameters.toml").read_text("utf-8"))[
    "wrong"
]


def methods_of(words, name):
    """The named methods, or those with fixed steps of these orders that are meant for a scene."""
    first, *orders = words.split()
    if first != "fixed":
        return [first, *orders]
    return [
        method.name
        for method in find_methods("*")
        if method.control == "step"
        and str(method.order) in orders
        and meant(method, scene(name))
        and not engine_of(method).optional
    ]


def rows(wrong):
    """Each scene, method and parameter, but for parameters that are zero."""
    for name in wrong["scenes"].split():
        for method in methods_of(wrong["methods"], name):
            for parameter, change in wrong["changes"].items():
                if value := scene(name).parameters[parameter]:
                    other = SUPPORTS.get(change) or value * (1.0 + change)
                    yield name, method, parameter, other, wrong


# What the short suite runs comes first: the first row of each but MuJoCo's turns with their feet,
# which take longest.
NUMBERED = [(i, row) for wrong in WRONG for i, row in enumerate(rows(wrong))]
SLOW_ROWS = sum(
    wrong.get("step", 0.0) > 1.0 and "mujoco" in wrong["methods"] for wrong in WRONG
)


def late(numbered):
    """Whether a row comes later in its table, and whether it takes long."""
    i, (_, method, _, _, wrong) = numbered
    return i > 0, wrong.get("step", 0.0) > 1.0 and "mujoco" in method


ROWS = [row for _, row in sorted(NUMBERED, key=late)]


def verdict(found, method):
    """The verdict on a run."""
    return judge(found, case_of(scene(found.scene)).system, method).verdict


@pytest.mark.long(keep=len(WRONG) - SLOW_ROWS)
@pytest.mark.parametrize(
    ("name", "method", "parameter", "value", "wrong"),
    ROWS,
    ids=["-".join(row[:3]) for row in ROWS],
)
def test_a_wrong_parameter(name, method, parameter, value, wrong):
    how = find_method(method)
    right = scene(name)
    other = scene(name, {parameter: value})
    if not installed(engine_of(how)):
        pytest.skip(f"{engine_of(how).package} is not installed: make peers")
    step = wrong.get("step") or how.step_sizes[-1]
    step = step if step < 1.0 else right.parameters["half_time"] / step
    right, other = (
        replace(case, duration=wrong.get("duration", case.duration)) for case in (right, other)
    )
    found, _ = run_of(how, right, step)
    if "stepped" in wrong:
        predicted = found.errors["theta"].predicted
        assert predicted
        assert predicted.uncertainty is not None
    assert verdict(found, how) == "predicted"
    assert verdict(run_of(how, right, step, other)[0], how) == "off-prediction"
