"""What benchmarks share: ratios of times are held to their limits, listed, and kept."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from plumbob.engines.study.provenance import provenance
from plumbob.reports.judge.benchmarks import BenchmarkRun, Ratio
from plumbob.tests.support.benchmark_runs import add, holds, limit, ratio

HISTORY = Path(".benchmarks") / "history.jsonl"
RATIOS = pytest.StashKey[list[Ratio]]()
Hold = Callable[..., None]


def pytest_addoption(parser):
    """Where the runs are kept."""
    word = "file that every run of the benchmarks is added to"
    parser.addoption("--history", default=str(HISTORY), metavar="FILE", help=word)


@pytest.fixture
def hold(pytestconfig):
    """Keep a ratio by its name and turns, and hold it to its limits."""

    def held(name, values, most=math.inf, least=0.0):
        found = ratio(name, values, most, least)
        pytestconfig.stash.setdefault(RATIOS, []).append(found)
        assert holds(found), f"{name}: {found.median:.3g}, {limit(found)}"

    return held


def pytest_terminal_summary(terminalreporter, config):
    """A table of the ratios, and where they are kept."""
    found = config.stash.get(RATIOS, [])
    if not found:
        return
    file = Path(config.getoption("--history"))
    add(BenchmarkRun(provenance("make benchmark"), tuple(found)), file)
    terminalreporter.section("ratios of times: median [quartiles], limit")
    for one in found:
        sign = " " if holds(one) else "!"
        figures = f"{one.median:8.3g} [{one.low:.3g}, {one.high:.3g}]"
        terminalreporter.line(f"{sign} {one.name:<58} {figures:<28} {limit(one)}")
    terminalreporter.line(f"added to {file}; what has moved: plumbob compare {file}#N {file}")
