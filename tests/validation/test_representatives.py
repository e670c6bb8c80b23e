"""The short suite of tests leaves out what it says and no more, and everything is run elsewhere."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from plumbob.engines.registry import methods
from plumbob.engines.study.runner import pairs
from plumbob.models.registry import scenes
from plumbob.tests.validation.representatives import left_out, mechanisms, representatives

ROOT = Path(__file__).parents[2]


def _case(name, mark):
    return SimpleNamespace(nodeid=name, get_closest_marker=lambda _: mark)


def test_representatives_miss_no_mechanism():
    chosen = pairs(scenes("*", "quick"), methods("*"))
    stand = representatives(chosen)
    assert {one for pair in chosen for one in mechanisms(*pair)} == {
        one for pair in stand for one in mechanisms(*pair)
    }
    assert len(stand) < 0.42 * len(chosen)


def test_cases_beyond_those_that_are_kept_are_left_out():
    all_long, some_long = pytest.mark.long.mark, pytest.mark.long(keep=2).mark
    cases = [
        _case("a.py::one", None),
        _case("a.py::two", all_long),
        *(_case(f"a.py::three[{k}]", some_long) for k in range(4)),
        *(_case(f"b.py::three[{k}]", some_long) for k in range(2)),
    ]
    left = [case.nodeid for case in left_out(cases)]
    assert left == ["a.py::two", "a.py::three[2]", "a.py::three[3]"]


def test_a_part_is_left_out_that_is_small(request):
    """Of what this run has collected, where it has the whole suite: at most one test in five."""
    every = request.session.items
    if len(every) < 1000 or request.config.getoption("--suite") == "short":
        pytest.skip("not the whole suite")
    assert len(left_out(every)) < 0.2 * len(every)


@pytest.mark.parametrize(("where", "suite"), [("Makefile", "short"), (".ci/run", "whole")])
def test_who_runs_which(where, suite):
    """`make test` the short one, as pytest's last word unless ARGS say otherwise; CI the whole."""
    (line,) = [
        line
        for line in (ROOT / where).read_text("utf-8").splitlines()
        if f"--suite {suite}" in line and not line.startswith("#") and "##" not in line
    ]
    assert (
        line.endswith("$(ARGS)") if suite == "short" else line.startswith("make heyoka check test")
    )
