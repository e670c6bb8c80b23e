"""`plumbob report --single`: one file with the content of the whole site."""

import re

import pytest

from plumbob.reports.view.page import write_file
from plumbob.reports.view.site.writing import site_in_one_file
from plumbob.tests.support.browser import visited
from plumbob.tests.support.page_document import folded, site_files


@pytest.fixture(scope="module")
def single(shown, tmp_path_factory):
    return write_file(site_in_one_file(shown), tmp_path_factory.mktemp("single"), "all.html")


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
    tables = folded(file)
    text = file.read_text("utf-8")
    shown = re.sub(
        r" later\" data-table=(\d+)>(.*?)</details>",
        lambda place: f'">{place[2]}{tables[int(place[1])]}</details>',
        text,
    )
    return re.sub("<noscript>.*?</noscript>", "", shown)


def _text(html):
    """What stands between the tags of a page's main part."""
    main = html.partition("<main")[2].rpartition("</main>")[0]
    return re.sub(
        r"<[^>]+>", " ", re.sub(r"<script.*?</script>", " ", main, flags=re.S)
    ).split()


@pytest.mark.long
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
        visit.page.locator(".systems a").first.click()
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
