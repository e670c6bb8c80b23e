"""Print how large the pages of a site are: height, words, nodes, DOM ready, bytes, sheets.

    python -m plumbob.tests.site.figures OUT [PAGE ...]

OUT is a folder that `plumbob validate --out` or `plumbob report` wrote, PAGE a page in it: `index`
and `capsule-line` without. Nodes and height are counted after everything was opened and scrolled
to, at two widths; sheets are of A4.
"""

from __future__ import annotations

import re
import statistics
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from plumbob.tests.support.browser import driven, visited
from plumbob.tests.support.page_document import site_files

if TYPE_CHECKING:
    pass

WIDTHS = (1280, 390)  # [px]
LOADS = 5  # of which the median is taken
READY = 'performance.getEntriesByType("navigation")[0].domContentLoadedEventEnd'
HEADS = (
    "page",
    "width [px]",
    "height [px]",
    "opened [px]",
    "words",
    "nodes",
    "DOM ready [ms]",
    "kB",
    "sheets",
)


def measured(browser, page, width):
    """The figures of a page at a width [px], as text."""
    ready = [_ready(browser, page, width) for _ in range(LOADS)]
    with visited(browser, page, width=width) as visit:
        sheets = _sheets(visit) if width == max(WIDTHS) else "–"
        height = visit.ask("document.documentElement.scrollHeight")
        words = visit.ask("document.body.innerText.split(/\\s+/).length")
        visit.scroll_through()
        opened = visit.ask("document.documentElement.scrollHeight")
        nodes = visit.ask("document.querySelectorAll('*').length")
    return (
        page.stem,
        str(width),
        str(height),
        str(opened),
        str(words),
        str(nodes),
        f"{statistics.median(ready):.0f}",
        f"{page.stat().st_size / 1e3:.0f}",
        sheets,
    )


def _ready(browser, page, width):
    with visited(browser, page, width=width) as visit:
        return float(visit.ask(READY))


def _sheets(visit):
    paper = visit.page.pdf(format="A4", print_background=True)
    return str(len(re.findall(rb"/Type\s*/Page[^s]", paper)))


def main(arguments):
    """Print a line a page and width; returns an exit code."""
    folder, *wanted = arguments
    files = {file.stem: file for file in site_files(Path(folder) / "index.html")}
    print("\t".join(HEADS))
    with driven() as browser:
        for name in wanted or ("index", "capsule-line"):
            for width in WIDTHS:
                print("\t".join(measured(browser, files[name], width)))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
