"""Options and settings that every test shares."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

from plumbob.tests.contracts.second_copies import second_copies
from plumbob.tests.support.browser import driven

if TYPE_CHECKING:
    from playwright.sync_api import Browser

# Machines differ in speed, so no deadline; the same examples every time, so that failures repeat.
settings.register_profile("repeatable", deadline=None, derandomize=True, print_blob=True)
settings.register_profile("search", deadline=None, max_examples=2000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


class _RootIsAFolder:
    """pytest would import the `__init__.py` beside `tests` under the name of the checkout."""

    def pytest_collect_directory(
        self, path: Path, parent: pytest.Collector
    ) -> pytest.Collector | None:
        """The root of the checkout as a plain folder."""
        root = path == parent.config.rootpath
        return pytest.Dir.from_parent(parent, path=path) if root else None


def pytest_configure(config: pytest.Config) -> None:
    """Collect the root of the checkout, which is the package itself, as a plain folder."""
    config.pluginmanager.register(_RootIsAFolder())


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium under playwright, which can be started once a process and no more."""
    with driven() as found:
        yield found


@pytest.fixture(autouse=True, scope="session")
def _one_name_a_module() -> Iterator[None]:
    """Fail at the end of a run in which a module of ours was imported under a second name."""
    yield
    assert second_copies(sys.modules, Path(__file__).parents[1]) == []


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add what chooses the runs of tests/validation: the same words as `plumbob validate`."""
    group = parser.getgroup("plumbob", "which scenes and methods tests/validation runs")
    group.addoption("--profile", choices=("quick", "full"), default="quick", help="how much to run")
    group.addoption("--scenes", metavar="GLOB", default="*", help="scenes by name, as 'cone-*'")
    group.addoption("--methods", metavar="GLOB", default="*", help="methods by name, as 'ode/*'")
