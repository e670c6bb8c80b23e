"""One site of the whole quick profile, invented and not run, for all that look."""

import pytest

from plumbob.reports.view.site.writing import write_site
from plumbob.tests.site import whole_profile


@pytest.fixture(scope="session")
def study():
    """Every scene and method of the quick profile with errors of first order."""
    return whole_profile.study()


@pytest.fixture(scope="session")
def shown():
    """What its pages show."""
    return whole_profile.shown()


@pytest.fixture(scope="session")
def index(shown, tmp_path_factory):
    """The index of its site."""
    return write_site(shown, tmp_path_factory.mktemp("site"))
