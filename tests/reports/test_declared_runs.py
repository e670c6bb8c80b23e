"""The page runs no engine: it looks up exactly what its findings declared."""

from pathlib import Path

import pytest

from plumbob.engines.study.request import UndeclaredRun
from plumbob.reports.analyses import requests, section
from plumbob.reports.view.site.writing import one_file
from plumbob.tests.site.whole_profile import shown, small
from plumbob.tests.support.declared import findings_of, nothing, plan_of
from plumbob.tests.support.page_document import resolve
from plumbob.tests.support.studies import measured_quick, no_engine, quick


def test_the_page_of_a_small_study_runs_no_engine_and_asks_for_what_was_declared():
    pages = small()
    with no_engine():
        page = one_file(pages)
    assert "printed-hamiltonian" in page
    assert pages.common["study"].extras.looked_up == set(requests(plan_of(quick())))


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


def test_a_run_that_was_not_declared_is_refused():
    with pytest.raises(UndeclaredRun, match="cone-pendulum"):
        findings_of(section("cone-pendulum"), nothing())


def test_an_engine_that_is_run_is_seen():
    with no_engine(), pytest.raises(AssertionError, match="an engine was run"):
        measured_quick()
