"""What benchmarks share: ratios of times are held to their limits, and listed."""

import math
from collections.abc import Callable

import pytest

from plumbob.tests.support.benchmark_runs import Ratio, holds, limit, ratio

RATIOS = pytest.StashKey[list[Ratio]]()
Hold = Callable[..., None]


@pytest.fixture
def hold(pytestconfig):
    """Keep a ratio by its name and turns, and hold it to its limits."""

    def held(name, values, most=math.inf, least=0.0):
        found = ratio(name, values, most, least)
        pytestconfig.stash.setdefault(RATIOS, []).append(found)
        assert holds(found), f"{name}: {found.median:.3g}, {limit(found)}"

    return held


def pytest_terminal_summary(terminalreporter, config):
    """A table of the ratios."""
    found = config.stash.get(RATIOS, [])
    if not found:
        return
    terminalreporter.section("ratios of times: median [quartiles], limit")
    for one in found:
        sign = " " if holds(one) else "!"
        figures = f"{one.median:8.3g} [{one.low:.3g}, {one.high:.3g}]"
        terminalreporter.line(f"{sign} {one.name:<58} {figures:<28} {limit(one)}")
