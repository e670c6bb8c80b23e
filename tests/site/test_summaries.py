"""The pages of engines and sources begin with sums of what they list."""

import html
import re
from collections import Counter

import pytest

from plumbob.reports.view.site import first_screen
from plumbob.tests.support.page_document import site_files
from plumbob.tests.support.studies import verdicts


def _lead(index, name):
    """The first paragraph of a page, as text."""
    page = (site_files(index)[1].parent / f"{name}.html").read_text("utf-8")
    text = page.partition('<p class="lead">')[2].partition("</p>")[0]
    return " ".join(html.unescape(re.sub(r"<[^>]+>", "", text)).split())


@pytest.mark.long
def test_statements_of_the_sources_are_counted(index, shown):
    counted = Counter(of.verdict for f in shown.common["findings"] for of in f.statements)
    wrong = counted["corrected"] + counted["refuted"]
    assert min(counted.values()) > 0
    assert _lead(index, "sources").startswith(
        f"{counted['holds']} statements hold, {wrong} do not: {counted['corrected']} are corrected "
        f"and {counted['refuted']} refuted. {counted['extended']} go further"
    )


@pytest.mark.parametrize("meaning", ["predicted", "converges", "limit", "unexpected"])
def test_pairs_of_an_engine_sum_up_to_those_of_the_study(meaning, study):
    judged = verdicts(study)
    total = {of.meaning: of.count for of in first_screen.counts(judged)}
    by_engine = first_screen.by_engine(judged)
    assert {"mujoco", "pymunk", "ode"} <= set(by_engine)
    assert sum(counted[meaning] for counted in by_engine.values()) == total[meaning]
    some = {pair: of for pair, of in judged.items() if pair[1].startswith("ode/")}
    assert first_screen.by_engine(some) == {"ode": by_engine["ode"]}
