"""Links of a site: templates lead to ids, and each id to the page that has it."""

from __future__ import annotations

import re
from collections.abc import Mapping

from plumbob.reports.view.page import NAME

ID = re.compile(r' id="([^"]+)"')
LINK = re.compile(r'href="#(?!main")([^"]*)"')  # every page has a main part
INDEX = "index"
PAGES = "pages"  # the folder of all pages but the index
Places = Mapping[str, str]  # names of pages by the ids in them


def places_of(pages: Mapping[str, str]) -> Places:
    """The places in the texts of pages by name."""
    return {place: name for name, text in pages.items() for place in ID.findall(text)}


def address(places: Places, place: str, here: str = "") -> str:
    """The address of a place by its id, as seen from the page `here`, by default one that has none;
    the id of a page's beginning is its name."""
    page = places.get(place, here)
    if page == here:
        return f"#{place}"
    folder = f"{PAGES}/" if here == INDEX else ""
    file = f"../{NAME}" if page == INDEX else f"{folder}{page}.html"
    return file if page == place else f"{file}#{place}"


def linked(places: Places, text: str, here: str) -> str:
    """A text of the page `here` whose links lead to the files of other pages."""
    return LINK.sub(lambda link: f'href="{address(places, link[1], here)}"', text)
