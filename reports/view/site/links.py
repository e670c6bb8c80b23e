"""Which page of a site has a place, and its address as seen from another page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from plumbob.reports.view.page import NAME


@dataclass(frozen=True)
class Links:
    """The addresses of places as the page `here` links to them."""

    places: Mapping[str, str]  # by id: the file of the page that has it, "" for the index
    here: str  # file of the page, "" for the index
    folder: str  # of all other pages, as the index sees it: "pages/"
    single: bool  # all pages are in one file, which finds them by their ids

    def __call__(self, place: str) -> str:
        """The address of a place by its id; the id of a page's beginning is its name."""
        file = self.places.get(place, self.here)
        if self.single or file == self.here:
            return f"#{place}"
        to = f"../{NAME}" if not file else f"{'' if self.here else self.folder}{file}"
        return to if file == page_file(place) else f"{to}#{place}"


def page_file(name: str) -> str:
    """The file of the page of that name."""
    return f"{name}.html"
