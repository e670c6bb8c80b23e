"""The pages of engines and sources begin with sums of what they list."""

import html
import re
from collections import Counter

import pytest

from plumbob.tests.support.page_document import site_files


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
