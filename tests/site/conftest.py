"""One site of the whole quick profile, invented and not run, for all that look."""

from __future__ import annotations

from pathlib import Path

import pytest

from plumbob.engines.study.results import Study
from plumbob.reports.findings import requests, section
from plumbob.reports.view.site.writing import Content, content, site
from plumbob.tests.support.declared import invented_study


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
