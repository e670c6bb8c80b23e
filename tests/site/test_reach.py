"""The pages of a whole study in Chromium: on a phone, by keyboard and screen reader, on paper."""

import re

import pytest

from plumbob.models.registry import systems
from plumbob.reports.view.page import PAGE_TEMPLATES
from plumbob.tests.support.browser import visited
from plumbob.tests.support.page_document import Document, broken_links, site_files

FILES = 8  # files that the index loads before a reader scrolls
NODES, KILOBYTES, STOPS, HEIGHT = 8000, 260.0, 60, 5000
# systems that the height is for, and [px] that each further one may add
LEAST, TALLER = 10, 100
PHONE, DESK, PAPER = 390, 1280, 703  # [px]; A4 within its margins
NAMES = ["index", *sorted(systems())]
FIRST = ["index", "capsule-line"]
SCENE = "capsule-line-ca1"  # of the scenes' pages the one with the most methods
# Of axe-core's rules those that look at colours. The dark theme is nothing but other values of the
# style sheets' colours, by the test below: every other rule sees there what it saw in the light.
OF_COLOURS = ("color-contrast", "link-in-text-block")
DARK = re.compile(r"@media \(prefers-color-scheme: dark\) \{(.*?)\n\}", re.S)
# What can be reached with the tab key before the first heading.
STOPS_BEFORE = """() => {
  const main = document.querySelector("main h1");
  const stops = [...document.querySelectorAll("a[href], button, summary, [tabindex]")];
  return stops.filter((one) => one.tabIndex >= 0 && one.checkVisibility() &&
    one.compareDocumentPosition(main) & Node.DOCUMENT_POSITION_FOLLOWING).length;
}"""
# What is pressed and is less than 24 px high or wide: links within a sentence aside, and what is
# folded; of what a label names, the label counts.
SMALL = """() => [...document.querySelectorAll("a[href], button, summary, select, [type=search]")]
  .filter((one) => one.checkVisibility() && !one.matches("p > a, .skip") &&
    !one.closest("details > *:not(summary)"))
  .filter((one) => {
    const at = one.getBoundingClientRect();
    return at.height < 24 || at.width < 24;
  }).map((one) => one.className || one.parentElement.className || one.textContent)"""
# On paper: tables beyond its edge, and the methods' names with a line's end inside a word.
ON_PAPER = """(width) => {
  const lines = (name) => {
    const text = document.createRange();
    const parts = [...name.childNodes].filter((one) => one.nodeType === 3 && one.data.trim());
    const tops = parts.flatMap((part) => {
      text.selectNodeContents(part);
      return [...text.getClientRects()].map((one) => Math.round(one.top));
    });
    return new Set(tops).size;
  };
  const tables = [...document.querySelectorAll("table")]
    .filter((one) => one.checkVisibility() && !one.closest(".matrix"));
  const names = tables.flatMap((one) => [...one.querySelectorAll("th.method")]);
  return [...tables.filter((one) => one.getBoundingClientRect().right > width + 1),
    ...names.filter((one) => lines(one) > 1)].map((one) => one.textContent.trim().slice(0, 40));
}"""
NARROW = """table tbody th.method {
  max-width: 30px; white-space: normal !important; overflow-wrap: anywhere !important }"""
# Text that is cut: boxes with more in them than they show, which do not scroll.
CUT = """() => [...document.querySelectorAll("body *")].filter((one) => {
  const style = getComputedStyle(one);
  return style.overflowX === "hidden" && one.scrollWidth > one.clientWidth + 1 &&
    one.checkVisibility() && !one.closest(".away, svg, .area, .scroll");
}).map((one) => one.className || one.tagName)"""


def _page(index, name):
    return index if name == "index" else site_files(index)[1].parent / f"{name}.html"


def pytest_generate_tests(metafunc):
    """Every page in the full profile; else one of each template, the fullest: the rest are made of
    the same parts."""
    if metafunc.definition.name == "test_nothing_is_out_of_reach":
        full = metafunc.config.getoption("--profile") == "full"
        metafunc.parametrize("name", [*(NAMES if full else FIRST), SCENE])


@pytest.mark.long
def test_nothing_is_out_of_reach(name, index, browser, pytestconfig):
    """No violation of axe-core, nothing wider than the window, and few elements, at two widths, in
    light and dark (where colours alone differ), with everything opened."""
    page = _page(index, name)
    assert page.is_file()
    with visited(browser, page) as visit:
        assert visit.ask(STOPS_BEFORE) <= STOPS
        assert _faults(visit, whole=pytestconfig.getoption("--profile") == "full") == []
        assert visit.console == []
        assert all(url.startswith("file:") for url in visit.requests)


def _faults(visit, *, whole=False):
    """What is wrong with a page in any look. axe-core is given the `whole` page, or one of all
    that is alike but for its words."""
    found = []
    for width in (PHONE, DESK):
        visit.look(width, "light")
        visit.scroll_through()
        wide, count = visit.ask(
            "[document.documentElement.scrollWidth, document.querySelectorAll('*').length]"
        )
        found += [f"{width}: {wide} wide"] if wide > width else []
        found += [f"{width}: {count} elements"] if count > NODES else []
        found += [f"{width}: cut: {cut}" for cut in visit.ask(CUT)]
    looks = [(width, scheme) for width in (DESK, PHONE) for scheme in ("light", "dark")]
    if not whole:
        visit.keep_one_of_each(looks)
    for width, scheme in looks:
        visit.look(width, scheme)
        rules = OF_COLOURS if scheme == "dark" else ()
        found += [f"{width}, {scheme}: {one}" for one in visit.violations(*rules)]
    return found


def test_the_dark_theme_changes_colours_alone():
    """Each declaration in it is one of a colour by its own name, on an element that is there."""
    sheets = {path.name: path.read_text("utf-8") for path in PAGE_TEMPLATES.glob("*.css")}
    blocks = {name: DARK.findall(text) for name, text in sheets.items()}
    assert blocks["page.css"]
    for name, text in sheets.items():
        assert text.count("prefers-color-scheme") == len(blocks[name]), name
        for block in blocks[name]:
            declared = re.sub(r"[^{}]*\{([^{}]*)\}", r"\1", block).split(";")
            assert all(re.match(r"\s*(--[a-z-]+: |$)", one) for one in declared), (
                name,
                declared,
            )
            sizes = [one for one in declared if re.search(r"\d(px|em|rem|%)(?! *$)", one)]
            assert sizes == [], (name, sizes)


@pytest.mark.long
def test_every_link_of_a_whole_study_leads_somewhere(index):
    files = site_files(index)
    assert broken_links({file: Document(file.read_text("utf-8")) for file in files}) == []


@pytest.mark.long
@pytest.mark.parametrize("name", ["index", "capsule-line", SCENE])
def test_what_is_pressed_is_large_enough(name, index, browser):
    for width in (DESK, PHONE):
        with visited(browser, _page(index, name), width=width) as visit:
            assert visit.ask(SMALL) == []
            visit.page.add_style_tag(
                content="summary { min-height: 0; line-height: 1 !important }"
            )
            assert visit.ask(SMALL) != []


@pytest.mark.long
@pytest.mark.parametrize("name", ["capsule-line", "sources", SCENE])
def test_on_paper_no_column_is_cut_and_no_name_broken(name, index, browser):
    with visited(browser, _page(index, name), width=PAPER) as visit:
        visit.page.emulate_media(media="print")
        assert visit.ask(ON_PAPER, PAPER) == []
        if name == SCENE:
            for wrong in ("table { min-width: 900px }", NARROW):
                style = visit.page.add_style_tag(content=wrong)
                assert visit.ask(ON_PAPER, PAPER) != []
                style.evaluate("(one) => one.remove()")


@pytest.mark.long
def test_verdicts_and_methods_fit_on_a_phone(index, browser):
    """A verdict stands beside the errors, and its reason is shown after a tap; the buttons of the
    methods are folded."""
    chips = "[...document.querySelectorAll('td.spelled .chip')]"
    with visited(browser, _page(index, SCENE), width=PHONE) as visit:
        rights = visit.ask(f"{chips}.map((one) => one.getBoundingClientRect().right)")
        assert len(rights) > 5
        assert max(rights) <= PHONE
        verdict = visit.page.locator("td.spelled .hint").first
        verdict.click()
        assert visit.page.locator("#tip").inner_text() == verdict.get_attribute("data-hint")
        assert visit.page.locator(".why:visible").count() == 0
        assert visit.page.locator("[data-method]:visible").count() == 0
        visit.look(DESK, "light")
        assert visit.page.locator(".why:visible").count() > 5


@pytest.mark.long
@pytest.mark.parametrize("name", ["index", "cone-pendulum", SCENE])
def test_every_button_works(name, index, browser):
    """Hints appear on focus, tap and hover; methods come and go; tables of plots open."""
    with visited(browser, _page(index, name)) as visit:
        visit.ask("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
        _copies(visit)
        if name == SCENE:
            _hints(visit)
            _methods(visit)
            _table_of_a_plot(visit)
        assert visit.console == []


def _copies(visit):
    for button in visit.page.locator("[data-copy]").all():
        button.click()
        said = button.locator("xpath=..").locator("[role=status]")
        said.filter(has_text=re.compile("copied|selected")).wait_for()


def _hints(visit):
    tip = visit.page.locator("#tip")
    first = visit.page.locator(".hint").first
    first.focus()
    assert tip.is_visible()
    assert tip.inner_text() == first.get_attribute("data-hint")
    visit.page.keyboard.press("ArrowDown")
    assert visit.ask("document.activeElement.dataset.hint") == tip.inner_text()
    assert not first.evaluate("(one) => one === document.activeElement")
    visit.page.keyboard.press("Escape")
    assert tip.is_hidden()
    last = visit.page.locator(".hint").last
    last.click()
    assert tip.inner_text() == last.get_attribute("data-hint")


def _methods(visit):
    plot = visit.page.locator(".area").first
    plot.locator("button").focus()
    visit.page.keyboard.press("Enter")
    plot.locator(".main-svg").first.wait_for()
    curves = "document.querySelector('.area').querySelectorAll('.scatterlayer .trace').length"
    before = visit.ask(curves)
    # The closed form has a button and, on this plot, no curve.
    off = visit.page.locator("[data-method='mujoco/rk4'][aria-pressed=false]")
    off.click()
    visit.until(f"{curves} > {before}")
    visit.page.locator("[data-every]").click()
    assert visit.page.locator("[data-method][aria-pressed=false]").count() == 0


def _table_of_a_plot(visit):
    visit.ask(
        "document.querySelectorAll('details.data').forEach((one) => { one.open = false; })"
    )
    summary = visit.page.locator("details.data > summary").first
    summary.click()
    rows = visit.page.locator("details.data[open] tbody tr")
    rows.first.wait_for()
    assert rows.count() > 5
    summary.click()
    rows.first.wait_for(state="detached")


@pytest.mark.long
def test_an_index_is_short_and_light(index, browser):
    """With all that is folded: what leads a reader is within a few screens."""
    assert index.stat().st_size < KILOBYTES * 1e3
    with visited(browser, index) as visit:
        tallest = HEIGHT + (len(systems()) - LEAST) * TALLER
        assert visit.ask("document.documentElement.scrollHeight") <= tallest
        assert len([url for url in visit.requests if url.startswith("file:")]) <= FILES
