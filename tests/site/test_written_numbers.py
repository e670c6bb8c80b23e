"""How numbers and symbols are written: over the visible text of all pages."""

import html
import re

import pytest

from plumbob.reports.view.page import with_mathml
from plumbob.reports.view.site.writing import write_site
from plumbob.tests.site import whole_profile
from plumbob.tests.support.page_document import folded, site_files

# What no page shows: {what is wrong: pattern}
REFUSED = {
    "rounding of double precision": r"\d\.\d*(?:0{11}|9{11})\d",
    "a thousand of a unit": r"(?<![\d.,])1000 (?:nm|µm|mm|ns|µs|ms)\b",
    "an exponent with a plus sign": r"\de\+\d",
    "a subscript as plain text": r"\b[A-Z]_[a-z]{1,2}\b",
    "a dot that small letters lose": "[\u0307\u0308]",
}
PLANTED = (
    "0.29999999999999999",
    "0.30000000000000004",
    "a step of 1000 µm",
    "×1.1e+02",
    "I_z",
    "θ\u0307",
)


def _visible(markup):
    """The text of HTML that a reader sees, without commands and code."""
    hidden = r"<(script|style|svg|code|pre|title|math)\b.*?</\1>"
    text = re.sub(hidden, " ", markup, flags=re.S)
    return html.unescape(re.sub(r"<[^>]+>", " ", text)).replace("\u00a0", " ")


def _faults(markup):
    text = _visible(markup)
    return [
        (wrong, text[max(0, found.start() - 30) : found.end() + 20])
        for wrong, pattern in REFUSED.items()
        for found in re.finditer(pattern, text)
    ]


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """A site of measured runs: its findings have numbers that an invented study lacks."""
    return write_site(whole_profile.small(), tmp_path_factory.mktemp("measured"))


@pytest.mark.long
@pytest.mark.parametrize("site", ["index", "measured"])
def test_every_page_writes_numbers_and_symbols_plainly(site, request):
    for file in site_files(request.getfixturevalue(site)):
        text = file.read_text("utf-8") + "".join(folded(file))
        assert _faults(text) == [], file.name


@pytest.mark.parametrize("planted", PLANTED)
def test_what_is_refused_is_found(planted):
    assert len(_faults(f"<p>an error of {planted} m</p>")) == 1
    assert _faults("<p>0.3 and 1 mm, 110×, 19.6550931687500001, Iₓ</p>") == []


def test_symbols_become_mathml_outside_of_tags():
    text = '<p title="I_z">½ I_yz ω² θ\u0307² of model_a</p>'
    assert with_mathml(text) == (
        '<p title="I_z">½ <math><msub><mi>I</mi><mi>yz</mi></msub></math> ω² '
        '<math><mover accent="true"><mi>θ</mi><mo>˙</mo></mover></math>² of model_a</p>'
    )
