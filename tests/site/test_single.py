"""`plumbob report --single`: one file with the content of the whole site."""

import gzip
import re

import pytest

from plumbob.models.registry import systems
from plumbob.reports.view.page import written
from plumbob.reports.view.site.writing import one_file
from plumbob.tests.support.browser import visited
from plumbob.tests.support.page_document import folded, site_files

MEGABYTES = 9.0
OF_SITE = 7.0  # [MB]: of a site to publish, with 23 systems
SIZE_OF_PICTURE = """() => {
  const box = document.querySelector(".model image").getBBox();
  return [box.width, box.height];
}"""


@pytest.fixture(scope="module")
def single(shown, tmp_path_factory):
    return written(one_file(shown), tmp_path_factory.mktemp("single"), "all.html")


def test_it_is_small(single):
    assert single.stat().st_size < MEGABYTES * 1e6


def test_a_site_is_small(index):
    files = [index, *(file for file in site_files(index)[1].parent.iterdir())]
    assert sum(file.stat().st_size for file in files) < OF_SITE * 1e6


def test_nothing_large_is_in_it_twice(single):
    """Each model's picture and each replay is held by one page, and others take it from there."""
    text = single.read_text("utf-8")
    pictures = re.findall(r'"data:image/png;base64,([^"]+)"', text)
    replays = re.findall(r'<figure class="replay" id="([^"]+)"', text)
    assert len(pictures) == len(set(pictures)) > 1
    assert len(replays) == len(set(replays)) > len(systems())
    taken = re.findall(r'data-from="([^"]+)"', text)
    assert len(taken) > len(systems())
    assert all(text.count(f' id="{name}"') == 1 for name in taken)
    assert not re.search(
        r"</t[dhr]>", re.sub(r"<table>\n<caption>Symbols.*?</table>", "", text, flags=re.S)
    )


def _whole(html, text):
    """A page of the file `text` with what it takes from others."""

    def held(gap):
        name = re.escape(gap[1])
        found = re.search(
            rf'<figure[^>]* id="{name}".*?</figure>|<image id="{name}"[^>]*/>', text, re.S
        )
        return found[0]

    return re.sub(r'<(?:figure|image) data-from="([^"]+)"(?:></figure>|/>)', held, html)


def _unfolded(file):
    """A page of a site with the tables in it that its script would show."""
    tables, text = folded(file), file.read_text("utf-8")
    shown = re.sub(
        r" later\" data-table=(\d+)>(.*?)</details>",
        lambda place: f'">{place[2]}{tables[int(place[1])]}</details>',
        text,
    )
    return re.sub("<noscript>.*?</noscript>", "", shown)


def test_without_a_script_a_file_has_all_folded_tables(index):
    _, *others = site_files(index)
    text = gzip.decompress((others[0].parent / "tables.html.gz").read_bytes()).decode()
    tables = [(file.stem, table) for file in others for table in folded(file)]
    assert len(tables) > len(others)
    assert all(f"<h2>{name}</h2>{table}" in text for name, table in tables)


def _text(html):
    """What stands between the tags of a page's main part."""
    main = html.partition("<main")[2].rpartition("</main>")[0]
    return re.sub(r"<[^>]+>", " ", re.sub(r"<script.*?</script>", " ", main, flags=re.S)).split()


def test_it_has_the_content_of_every_page(single, index):
    text = single.read_text("utf-8")
    parts = dict(re.findall(r'<template data-page="([^"]+)">(.*?)</template>', text, re.S))
    first, *others = site_files(index)
    assert set(parts) == {file.stem for file in others}
    for file in others:
        assert _text(_whole(parts[file.stem], text)) == _text(_unfolded(file)), file.name
    assert _text(text.partition("<template")[0]) == _text(first.read_text("utf-8"))


@pytest.mark.long
def test_its_links_turn_pages(single, browser):
    with visited(browser, single) as visit:
        heading = visit.page.locator("h1")
        first = heading.inner_text()
        visit.page.locator("ul.systems a").first.click()
        heading.filter(has_text="Cone pendulum").wait_for()
        visit.page.locator(".matrix tbody a").first.click()
        heading.filter(has_text="Cone pendulum on a rotating platform: ").wait_for()
        plot = visit.page.locator(".area").first
        plot.locator("button").click()
        plot.locator(".main-svg").first.wait_for()
        visit.page.go_back()
        heading.filter(has_text="Cone pendulum").wait_for()
        visit.page.locator(".crumbs a").first.click()
        heading.filter(has_text=first).wait_for()
        assert visit.console == []
        assert visit.requests == [single.resolve().as_uri()]


@pytest.mark.long
def test_a_link_from_outside_leads_to_a_place_on_a_page_which_takes_what_another_holds(
    single, browser
):
    """Two systems with the same picture show it, and both the canvas of their replay."""
    with visited(browser, single, "#printed-hamiltonian") as visit:
        found = visit.page.locator("#printed-hamiltonian > details")
        found.wait_for()
        assert found.get_attribute("open") is not None
        for name in ("capsule-line", "capsule-turn"):
            visit.ask("(name) => { location.hash = name; }", name)
            visit.page.locator(f"h1#{name}").wait_for()
            assert visit.ask(SIZE_OF_PICTURE) == [480, 360]
            visit.page.locator(".live canvas").wait_for()
        assert visit.console == []
