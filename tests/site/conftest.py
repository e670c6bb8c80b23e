"""One site of the whole quick profile, invented and not run, for all that look."""

from __future__ import annotations

from pathlib import Path

import pytest

from plumbob.engines.study.results import Study
from plumbob.reports.view.site.writing import Content, site
from plumbob.tests.site import whole_profile


@pytest.fixture(scope="session")
def study() -> Study:
    """Every scene and method of the quick profile with errors of first order."""
    return whole_profile.study()


@pytest.fixture(scope="session")
def shown() -> Content:
    """What its pages show."""
    return whole_profile.shown()


@pytest.fixture(scope="session")
def index(shown: Content, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The index of its site."""
    return site(shown, tmp_path_factory.mktemp("site"))
