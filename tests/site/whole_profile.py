"""What the pages show of the whole quick profile, invented and not run, and of a small study that
was measured: made once a run, with engines that refuse to run, for all that look."""

from dataclasses import replace
from functools import cache

from plumbob.reports.analyses import analyses_of, requests
from plumbob.reports.view.finding_text import findings_of
from plumbob.reports.view.site.writing import site_content
from plumbob.tests.sharing.shared import shared
from plumbob.tests.support.declared import invented_study
from plumbob.tests.support.studies import Asked, no_engine, quick


@cache
def study():
    """Every scene and method of the quick profile with errors of first order: their places on the
    pages are those of a measured study, and most are unexpected."""
    return shared("whole-study", _invented)


def _invented():
    with no_engine():
        return invented_study(requests)


@cache
def shown():
    """What its pages show, and what they asked for: its study's extras are `Asked`."""
    return _whole()[0]


def findings():
    """The findings of its pages, as they are where all that they claim holds."""
    return _whole()[1]


@cache
def small():
    """The same of the small study that is measured."""
    return shared("small-pages", lambda: _pages(quick()))


@cache
def _whole():
    return shared("whole-pages", lambda: _shown(study()))


def _shown(study):
    """What the pages of a study show, and the findings before it is seen whether they hold."""
    asked = replace(study, extras=Asked(study.extras))
    with no_engine():
        analysed = analyses_of(asked)
    kept = [finding for a in analysed if a.place == "finding" for finding in findings_of(a)]
    return _pages(replace(asked, analyses=analysed)), tuple(kept)


def _pages(analysed):
    with no_engine():
        return site_content(analysed)
