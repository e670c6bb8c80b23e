"""Links between the pages of a site: a template links to an id, and the page with that id is looked
up when the site is written."""

from __future__ import annotations

import re
from collections.abc import Mapping

from plumbob.reports.view.page import NAME

ID = re.compile(r' id="([^"]+)"')
LINK = re.compile(r'href="#(?!main")([^"]*)"')  # every page has a main part
INDEX = "index"
PAGES = "pages"  # the folder of all pages but the index
PageById = Mapping[str, str]  # page name for each id


def pages_by_id(pages: Mapping[str, str]) -> PageById:
    """Returns the name of the page that holds each id; `pages` are HTML texts by page name."""
    return {place: name for name, text in pages.items() for place in ID.findall(text)}


def relative_address(places: PageById, place: str, here: str = "") -> str:
    """Returns the relative address of the id `place`, as a link on the page `here` needs it.

    An id equal to a page's name stands for the beginning of that page. If no page has the id, the
    address stays on the page `here`."""
    page = places.get(place, here)
    if page == here:
        return f"#{place}"
    folder = f"{PAGES}/" if here == INDEX else ""
    file = f"../{NAME}" if page == INDEX else f"{folder}{page}.html"
    return file if page == place else f"{file}#{place}"


def resolve_links(places: PageById, text: str, here: str) -> str:
    """Returns the HTML text of the page `here` with each link to an id replaced by the relative
    address of that id."""
    return LINK.sub(lambda link: f'href="{relative_address(places, link[1], here)}"', text)
