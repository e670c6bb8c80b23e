"""`validate --repeat`: each pair again, in another process and in the opposite order; other bits
are unexpected unless the engine declares them."""

import json
from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.known_limits import Limits, read_limits
from plumbob.engines.registry import method as find_method
from plumbob.engines.study import repeating
from plumbob.engines.study.convergence import convergence_study
from plumbob.engines.study.repeating import OtherBits
from plumbob.models.registry import scene as find_scene
from plumbob.reports.cli import main
from plumbob.tests.commands.outcomes import without_findings, without_pages

SCENE, METHOD = "linear-pendulum/overdamped", "ode/rk4"
LIMITS = """[[not_repeatable]]
scenes = ["linear-pendulum/*"]
methods = ["ode/*"]
reason = "threads add up in any order"
"""


@pytest.fixture(scope="module")
def series():
    """The convergence study of a pair, of two steps."""
    return convergence_study(find_scene(SCENE), find_method(METHOD), 1000, (0.1, 0.05))


def with_error(series, **change):
    """The series in which the angle's error of the second run is changed."""
    first, run = series.measurements
    errors = {**run.errors, "theta": replace(run.errors["theta"], **change)}
    return replace(series, measurements=(first, replace(run, errors=errors)))


def test_the_same_bits_are_equal_whatever_time_they_took(series):
    slower = tuple(replace(run, seconds=7.0) for run in series.measurements)
    assert not [*repeating._differences(series, replace(series, measurements=slower))]


def test_a_unit_in_the_last_place_is_another_bit(series):
    step, end = series.measurements[1].step, series.measurements[1].errors["theta"].end
    other = float(np.nextafter(end, np.inf))
    (found,) = repeating._differences(series, with_error(series, end=other))
    assert found == OtherBits(step, "theta", end, other)


def test_a_run_that_is_missing_is_a_difference_both_ways(series):
    less = replace(series, measurements=series.measurements[:1])
    (missing,) = repeating._differences(series, less)
    (more,) = repeating._differences(less, series)
    assert (missing.second, more.first) == ("not run", "not run")


def test_an_exception_that_is_declared_is_not_unexpected(series, monkeypatch, tmp_path):
    file = tmp_path / "limits.toml"
    file.write_text(LIMITS)
    other = with_error(series, end=0.5)
    assert repeating._repeated_pair(series, other).unexpected
    monkeypatch.setattr(repeating, "limits_of", lambda method: read_limits(file))
    found = repeating._repeated_pair(series, other)
    assert (found.unexpected, found.declared) == (False, "threads add up in any order")
    assert not repeating._repeated_pair(series, series).declared
    assert Limits().other_bits(SCENE, METHOD) == ""


@pytest.mark.parametrize(
    ("change", "code"), [(1, 1), pytest.param(0, 0, marks=pytest.mark.rare)]
)
def test_validate_repeat_says_whether_bits_differ(tmp_path, capsys, monkeypatch, change, code):
    """With another seed the second pass draws another step."""
    without_pages(monkeypatch)
    without_findings(monkeypatch)
    task = repeating.convergence_task
    monkeypatch.setattr(
        repeating,
        "convergence_task",
        lambda scene, method, profile, seed: task(scene, method, profile, seed + change),
    )
    words = ("--scenes", SCENE, "--methods", METHOD, "--repeat", "--jobs", "1", "--json")
    assert main(("validate", *words, "--out", str(tmp_path / "out"))) == code
    rows = json.loads(capsys.readouterr().out)
    assert {row["same_bits"] for row in rows} == {not change}
