"""The search for the first release that differs, over planted results."""

import math
from dataclasses import dataclass

import pytest

from plumbob.engines.releases.measuring import Release
from plumbob.reports.judge import release_changes as module
from plumbob.reports.judge.release_changes import ReleaseChange, first_change


@dataclass(frozen=True)
class Planted(Release):
    """A release whose result is a number."""

    result: float = 1.0


@pytest.fixture(autouse=True)
def _results_are_numbers(monkeypatch):
    def changes(old, new):
        growth = new.result / old.result - 1.0
        return [ReleaseChange("", "", "scene", "error", "", "", growth)] if growth else []

    monkeypatch.setattr(module, "release_changes", changes)


def search(results, limit=0.0):
    """The first change in a row of results; None stands for a release without results."""
    versions = [str(number) for number in range(len(results))]

    def measure(number):
        result = results[number]
        if result is None:
            return Planted(versions[number], why="not installed")
        return Planted(versions[number], result=result)

    return first_change(versions, measure, limit)


@pytest.mark.parametrize("count", [2, 3, 8, 9, 31])
def test_the_first_release_that_differs_is_found(count):
    """Whatever the release, in the number of measurements that a search by halves needs."""
    for at in range(1, count):
        first = search([1.0] * at + [2.0] * (count - at))
        assert (first.outcome, first.before, first.version) == ("moved", str(at - 1), str(at))
        assert len(first.tried) <= math.ceil(math.log2(count)) + 2
    none = search([1.0] * count)
    assert none.outcome == "none"
    assert len(none.tried) <= math.ceil(math.log2(count)) + 2


def test_a_change_that_goes_back_is_called_so():
    first = search([1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 1.0, 1.0])
    assert (first.outcome, first.before, first.version) == ("returned", "2", "3")


def test_two_changes_are_called_so():
    first = search([1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0])
    assert (first.outcome, first.version) == ("several", "2")


def test_small_changes_are_none():
    assert search([1.0, 1.0, 1.01, 1.01], limit=0.05).outcome == "none"
    assert search([1.0, 1.0, 1.01, 1.01], limit=0.005).version == "2"
    assert search([1.0, 1.0, 0.9, 0.9], limit=0.05).version == "2"


def test_a_release_without_results_differs():
    assert search([1.0, 1.0, None, None]).version == "2"
