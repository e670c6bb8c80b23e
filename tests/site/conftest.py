"""One site of the whole quick profile, invented and not run, and one browser for all that look."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from plumbob.engines.study.results import Study
from plumbob.reports.findings import requests, section
from plumbob.reports.view.site.writing import Content, content, site
from plumbob.tests.support.browser import driven
from plumbob.tests.support.declared import invented_study

if TYPE_CHECKING:
    from playwright.sync_api import Browser


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium."""
    with driven() as found:
        yield found


@pytest.fixture(scope="session")
def study() -> Study:
    """Every scene and method of the quick profile with errors of first order: their places on the
    pages are those of a measured study, and most are unexpected."""
    return invented_study(requests)


@pytest.fixture(scope="session")
def shown(study: Study) -> Content:
    """What its pages show."""
    return content(study, section)


@pytest.fixture(scope="session")
def index(shown: Content, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The index of its site."""
    return site(shown, tmp_path_factory.mktemp("site"))
