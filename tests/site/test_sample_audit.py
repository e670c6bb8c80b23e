"""The sample page of an audit, which "My own file" leads to, says what an audit finds."""

import re
from pathlib import Path

import pytest

import plumbob
from plumbob.reports.view.audit.html import sample_audit
from plumbob.reports.view.site.writing import write_study_pages
from plumbob.tests.site import chosen
from plumbob.tests.support.page_document import words
from plumbob.tests.validation.sample_audit import audited_now


def test_my_own_file_leads_to_a_page_with_an_answer_and_a_replay(tmp_path):
    index = write_study_pages(chosen.study(), tmp_path)
    own = index.read_text("utf-8").partition('id="kind-own"')[2].partition("</article>")[0]
    (link,) = re.findall(r'href="(pages/[^"]+)"', own)
    text = (tmp_path / link).read_text("utf-8")
    assert sample_audit().report.headline[1:] in text.replace("\u00a0", " ")
    assert len(re.findall(r'<li class="tile (?:good|fair|bad)">', text)) == 4
    assert '<figure class="replay"' in text
    assert "What makes it better" in text


def test_the_audited_file_is_shipped():
    model = words(sample_audit().command)[1]
    assert (Path(plumbob.__file__).parent / model).is_file()


def test_each_row_of_the_page_has_a_cell_for_each_column():
    """A line of a template that begins with an empty cell was read as a row of its own."""
    for table in sample_audit().finding.tables:
        assert {len(row) for row in table.rows} == {len(table.heads)}, table.caption


def _found(content):
    """What an audit found, without costs, which differ from machine to machine."""
    runs = next(t for t in content.finding.tables if t.caption.startswith("Every run"))
    return (
        content.finding.title,
        content.finding.summary,
        content.report.headline,
        [(tile.question, tile.grade) for tile in content.report.tiles],
        content.report.warnings,
        content.report.fixes.heads,
        [[cell.text for cell in row[:3]] for row in runs.rows],
        content.replay.layers,
        [
            (of.title, [(t["name"], t["line"]) for t in of.traces])
            for of in content.finding.figures
        ],
    )


@pytest.mark.rare
def test_the_shipped_page_is_what_an_audit_finds_now():
    """Its errors are printed with two digits, which rounding on another processor leaves alone."""
    assert _found(audited_now()) == _found(sample_audit())
