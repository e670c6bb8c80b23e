"""A page filled with its content: one file with everything, or one of several that share files."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import os
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from plumbob.reports.view import notation
from plumbob.reports.view.content import Figure
from plumbob.reports.view.drawing import Drawing, drawing
from plumbob.reports.view.own_files import replaceable
from plumbob.reports.view.tables import environment

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

TEMPLATES = Path(__file__).parent / "templates"
NAME = "index.html"
UNITS = re.compile(
    r"(?<=\d) (?=(?:%|m?s|[nµmck]?m|rad|N|J|W|°)(?![\w]))"
)  # no line ends before one
INDENT = re.compile(r"^ +(?:// .*\n)?", re.MULTILINE)  # of a script, with its remarks
CODE = re.compile("`([^`]+)`")
EXPONENT = re.compile(r"-?\d[\d.]*e-\d+")  # a line may end after a hyphen
PLAIN = " =/:;,.()'-{}!*"  # what an address of data may hold as it is
STYLE, SCRIPT, PLOTLY, ICON = "page.css", "page.js", "plotly.js", "icon.svg"


@dataclass(frozen=True)
class Plots:
    """The parts of one page that its script shows when they are wanted, as it is filled: pictures,
    the data that plotly draws, folded tables and what a replay moves."""

    folder: str | None = None  # where the page finds their files; None: inside the page
    page: str = ""  # its name
    # a figure each, as plotly takes it
    data: list[Mapping[str, Any]] = field(default_factory=list)
    tables: list[str] = field(default_factory=list)  # HTML, a table each
    files: dict[str, str] = field(default_factory=dict)  # by name

    def picture(
        self, figure: Figure, chosen: Sequence[str], still: bool = False
    ) -> tuple[str, Drawing | None]:
        """The address and size of a figure's picture, of the `chosen` methods if it has some, which
        plotly draws anew where it is pressed; a `still` one cannot be, and stands in a column."""
        if not still:
            self.data.append({"data": figure.traces, "layout": figure.layout})
        drawn = drawing(replace(figure, wide=figure.wide and not still), chosen)
        if drawn is None:
            return "", None
        svg = _environment().get_template("figure.svg.jinja").render(of=drawn)
        if self.folder is None:
            return f"data:image/svg+xml,{quote(svg, safe=PLAIN)}", drawn
        name = f"{hashlib.sha256(svg.encode('utf-8')).hexdigest()[:12]}.svg"
        self.files[name] = svg
        return f"{self.folder}{name}", drawn

    def script(self) -> str:
        """The data compressed: its text, or the address of the script that will have it."""
        return packed(self.text()) if self.folder is None else f"{self.folder}{self.page}.js"

    def text(self) -> str:
        """The data as JSON."""
        return _json({"figures": self.data, "tables": self.tables})

    def beside(self, name: str, text: str) -> str:
        """A text compressed, or the address of the script of a name that has it."""
        if self.folder is None:
            return packed(text)
        self.files[f"{name}.js"] = carried(text)
        return f"{self.folder}{name}.js"


def packed(text: str) -> str:
    """A text compressed, in base64, which our script unpacks when it is wanted."""
    return base64.b64encode(gzip.compress(text.encode("utf-8"), 4, mtime=0)).decode("ascii")


def carried(text: str) -> str:
    """A script whose element holds a text compressed after it ran: a page in a folder can load no
    other."""
    return f'document.currentScript.textContent="{packed(text)}"'


def filled(
    template: str, *, shared: str | None = None, plots: Plots | None = None, **content: Any
) -> str:
    """A template of a page filled with its content. With `shared`, the path to the folder of a
    site, the page loads the files of `shared_files` from there; without, it holds them. Files of
    its `plots` are added to these."""
    from markupsafe import Markup

    held = shared_files(packed) if shared is None else {}
    inside = {name: Markup(text) for name, text in held.items()}
    defaults: dict[str, Any] = {
        "styles": {},
        "frame": "frame.html.jinja",
        "single": shared is None,
        "preview": None,
        "search": None,
        "plots": plots or Plots(),
    }
    return (
        _environment()
        .get_template(template)
        .render({**defaults, **content, "shared": shared, "inside": inside})
    )


@cache
def _environment() -> Environment:
    """The environment that reads the templates and caches them."""
    pages = environment(TEMPLATES, autoescape=True)
    pages.filters["kept"] = _kept
    pages.filters["numbers"] = lambda values: _json(dict(values))
    for write in (notation.number, notation.short, notation.seconds, notation.plural):
        pages.globals[write.__name__] = write
    return pages


def _kept(text: str) -> Markup:
    """A text in which no line ends inside a number, or before its unit, with its `code` as such."""
    from markupsafe import Markup, escape

    escaped = str(escape(UNITS.sub("\u00a0", text)))
    whole = EXPONENT.sub(r"<span class=nowrap>\g<0></span>", escaped)
    return Markup(CODE.sub(r"<code class=inline>\1</code>", whole))


@cache
def shared_files(hold: Callable[[str], str] = carried) -> Mapping[str, str]:
    """The style sheet, our script, plotly as `hold` has it and the icon, by name: what all pages of
    a site load, or one page holds."""
    from plotly.offline import get_plotlyjs

    styles, scripts = (
        "\n".join(
            INDENT.sub("", path.read_text("utf-8"))
            for path in sorted(TEMPLATES.glob(f"*.{kind}"))
        )
        for kind in ("css", "js")
    )
    icon = (TEMPLATES / ICON).read_text("utf-8")
    return {STYLE: styles, SCRIPT: scripts, PLOTLY: hold(get_plotlyjs()), ICON: icon}


def written(text: str | bytes, folder: Path, name: str) -> Path:
    """Write a page, or another file, into `folder` under `name`, whole or not at all, and return
    its path; raises OSError where the folder cannot be written, and ParameterError where it would
    replace a file that is not plumbob's."""
    replaceable("out", folder / name)
    folder.mkdir(parents=True, exist_ok=True)
    # A file in a folder has the permissions that the user's umask leaves, unlike a temporary file.
    with tempfile.TemporaryDirectory(prefix=".plumbob-", dir=folder) as scratch:
        part = Path(scratch) / name
        part.write_bytes(encoded(text))
        os.replace(part, folder / name)
    return folder / name


def encoded(text: str | bytes) -> bytes:
    """A file's content as bytes. Names of files may hold bytes that are no characters: these are
    escaped."""
    return text.encode("utf-8", "backslashreplace") if isinstance(text, str) else text


def _json(values: Any) -> str:
    return json.dumps(values, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
