"""Options and settings that every test shares."""

from __future__ import annotations

import os

import pytest
from hypothesis import settings

# Machines differ in speed, so no deadline; the same examples every time, so that red stays red.
settings.register_profile("repeatable", deadline=None, derandomize=True, print_blob=True)
settings.register_profile("search", deadline=None, max_examples=2000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add what chooses the runs of tests/validation: the same words as `plumbob validate`."""
    group = parser.getgroup("plumbob", "which scenes and methods tests/validation runs")
    group.addoption("--profile", choices=("quick", "full"), default="quick", help="how much to run")
    group.addoption("--scenes", metavar="GLOB", default="*", help="scenes by name, as 'cone-*'")
    group.addoption("--methods", metavar="GLOB", default="*", help="methods by name, as 'ode/*'")
