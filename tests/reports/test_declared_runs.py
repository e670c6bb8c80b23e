"""The page runs no engine: it looks up exactly what its findings declared."""

from pathlib import Path

import pytest

from plumbob.reports.analyses import requests
from plumbob.reports.analyses.measurements import study_plan
from plumbob.reports.view.site.writing import site_in_one_file
from plumbob.tests.site.whole_profile import shown, small
from plumbob.tests.support.page_document import resolve
from plumbob.tests.support.studies import no_engine, quick


def test_the_page_of_a_small_study_runs_no_engine_and_asks_for_what_was_declared():
    pages = small()
    with no_engine():
        page = site_in_one_file(pages)
    assert "printed-hamiltonian" in page
    assert pages.common["study"].extras.looked_up == set(requests(study_plan(quick())))


@pytest.mark.long
def test_the_pages_of_the_quick_profile_ask_for_what_was_declared_and_nothing_else():
    pages = shown()  # without an engine
    asked = pages.common["study"].extras
    assert asked.looked_up == set(asked)
    assert len(asked) > 100
    commands = [command for finding in pages.common["findings"] for command in finding.commands]
    assert commands
    for command in commands:
        resolve(command, Path())
