"""All errors of a site stand as per cent or as powers of ten, as a reader chooses once; without
JavaScript they are per cent."""

import pytest

from plumbob.tests.support.browser import visited
from plumbob.tests.support.page_document import site_files

TEXT = "document.getElementById('main').innerText"
CELLS = "[...document.querySelectorAll('.matrix td')].map((one) => one.innerText)"
CODES = "[...document.querySelectorAll('code, pre')].map((one) => one.textContent).join()"


def _choose(visit, language):
    visit.page.locator(f"[data-errors={language}]").click()


@pytest.mark.long
def test_one_switch_changes_all_errors_of_the_site(index, browser):
    scene = next(file for file in site_files(index) if file.stem == "capsule-line-ca1")
    with visited(browser, index) as visit:
        before, codes = visit.ask(TEXT), visit.ask(CODES)
        cells = visit.ask(CELLS)
        visit.page.locator("[data-errors=power]").wait_for()
        _choose(visit, "power")
        powers = visit.ask(CELLS)
        assert any("%" in text for text in cells)
        assert not any("%" in text for text in powers)
        # The same number, with the same digits: 2.5 % is 2.5e-2.
        for percent, power in zip(cells, powers, strict=True):
            if "%" in percent:
                number = float(percent.split()[1])
                assert float(power.split()[1]) == pytest.approx(number / 100, rel=1e-12)
        assert visit.ask(CODES) == codes
        # A table that its filter writes anew keeps the choice, and so does the next page.
        visit.page.locator("[data-step=default]").click()
        assert not any("%" in text for text in visit.ask(CELLS))
        visit.page.locator("[data-step='1ms']").click()
        visit.page.goto(scene.as_uri())
        visit.page.locator("[data-errors=power]").wait_for()
        assert " %" not in visit.ask(TEXT)
        _choose(visit, "percent")
        visit.page.goto(index.as_uri())
        visit.page.locator("[data-errors=power]").wait_for()
        assert visit.ask(TEXT) == before
        assert visit.console == []
