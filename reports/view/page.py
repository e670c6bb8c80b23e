"""A page filled with its content: one file with everything, or one of several that share files."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import os
import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import numpy as np

from plumbob.reports.view import compiled_templates
from plumbob.reports.view.content import Figure
from plumbob.reports.view.drawing import Drawing, drawing

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

TEMPLATES = Path(__file__).parent / "templates"
NAME = "index.html"
UNITS = re.compile(
    r"(?<=\d) (?=(?:%|m?s|[nµmck]?m|rad|N|J|W|°)(?![\w]))"
)  # no line ends before one
INDENT = re.compile(r"^ +(?:// .*\n)?", re.MULTILINE)  # of a script, with its remarks
EXPONENT = re.compile(r"-?\d[\d.]*e-\d+")  # a line may end after a hyphen
PLAIN = " =/:;,.()'-{}!*"  # what an address of data may hold as it is
FIRST = 0x1000  # the character that stands for 0, after all that a script may not hold
STYLE, SCRIPT, PLOTLY, ICON = "page.css", "page.js", "plotly.js", "icon.svg"


@dataclass(frozen=True)
class Plots:
    """The parts of one page that its script shows when they are wanted, as it is filled: pictures,
    the data that plotly draws, folded tables and what a replay moves."""

    folder: str | None = None  # where the page finds their files; None: inside the page
    page: str = ""  # its name
    data: list[str] = field(default_factory=list)  # JSON, a figure each
    tables: list[str] = field(default_factory=list)  # HTML, a table each
    files: dict[str, bytes] = field(default_factory=dict)  # by name

    def picture(self, figure: Figure, chosen: Sequence[str]) -> tuple[str, Drawing | None]:
        """The address and size of a figure's picture, of the `chosen` methods if it has some, which
        plotly draws anew where it is pressed."""
        self.data.append(figure_json(figure))
        return self._file(drawing(figure, chosen))

    def still(self, figure: Figure, chosen: Sequence[str]) -> tuple[str, Drawing | None]:
        """The same of a picture that cannot be pressed, and stands in a column."""
        return self._file(drawing(replace(figure, wide=False), chosen))

    def _file(self, drawn: Drawing | None) -> tuple[str, Drawing | None]:
        if drawn is None:
            return "", None
        if self.folder is None:
            return f"data:image/svg+xml,{quote(drawn.svg, safe=PLAIN)}", drawn
        content = drawn.svg.encode("utf-8")
        name = f"{hashlib.sha256(content).hexdigest()[:12]}.svg"
        self.files[name] = content
        return f"{self.folder}{name}", drawn

    def later(self, table: str) -> int:
        """The place of a table among those that are shown when they are wanted."""
        self.tables.append(table)
        return len(self.tables) - 1

    def script(self) -> str:
        """The data compressed: its text, or the address of the script that has it."""
        return self.beside(
            self.page, f'{{"figures":[{",".join(self.data)}],"tables":{_json(self.tables)}}}'
        )

    def beside(self, name: str, text: str) -> str:
        """A text compressed, or the address of the script of a name that has it."""
        if self.folder is None:
            return packed(text)
        self.files[f"{name}.js"] = carried(text)
        return f"{self.folder}{name}.js"


def packed(text: str) -> str:
    """A text compressed, in base64, which our script unpacks when it is wanted."""
    return base64.b64encode(compressed(text)).decode("ascii")


def carried(text: str) -> bytes:
    """A script whose element holds a text compressed after it ran: a page in a folder can load no
    other. It is in UTF-16, which its first bytes say whatever a server says, and holds 15 bits a
    character, after one that counts the bytes to leave out at the end."""
    bits = np.unpackbits(np.frombuffer(compressed(text), np.uint8))
    more = -len(bits) % 15
    rows = np.pad(bits, (0, more)).reshape(-1, 15)
    codes = np.packbits(np.pad(rows, ((0, 0), (1, 0))), axis=1).view(">u2").ravel() + FIRST
    held = np.concatenate([[FIRST + more // 8], codes]).astype("<u2").tobytes().decode("utf-16-le")
    return f'\ufeffdocument.currentScript.textContent="{held}"'.encode("utf-16-le")


def compressed(text: str) -> bytes:
    """A text compressed, the same bytes for the same text."""
    return gzip.compress(text.encode("utf-8"), 6, mtime=0)


def filled(
    template: str, *, shared: str | None = None, plots: Plots | None = None, **content: Any
) -> str:
    """A template of a page filled with its content. With `shared`, the path to the folder of a
    site, the page loads the files of `shared_files` from there; without, it holds them. Files of
    its `plots` are added to these."""
    from markupsafe import Markup

    inside = {name: Markup(text) for name, text in _inside().items()} if shared is None else {}
    defaults: dict[str, Any] = {
        "styles": {},
        "frame": "frame.html.jinja",
        "href": _same_page,
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
    environment = compiled_templates.environment(TEMPLATES, autoescape=True)
    environment.filters["kept"] = _kept
    environment.filters["numbers"] = lambda values: _json(dict(values))
    return environment


def _kept(text: str) -> Markup:
    """A text in which no line ends inside a number, or before its unit."""
    from markupsafe import Markup, escape

    escaped = str(escape(UNITS.sub("\u00a0", text)))
    return Markup(EXPONENT.sub(r"<span class=nowrap>\g<0></span>", escaped))


@cache
def shared_files() -> Mapping[str, bytes]:
    """The style sheet, our script, plotly and the icon, by name: what all pages of a site load."""
    from plotly.offline import get_plotlyjs

    files = {name: text.encode("utf-8") for name, text in _ours().items()}
    return {**files, PLOTLY: carried(get_plotlyjs())}


@cache
def _inside() -> Mapping[str, str]:
    """The same for a page that holds them, plotly compressed."""
    from plotly.offline import get_plotlyjs

    return {**_ours(), PLOTLY: packed(get_plotlyjs())}


def _ours() -> dict[str, str]:
    """Our style sheets, our scripts and the icon."""
    styles, scripts = (
        "\n".join(
            INDENT.sub("", path.read_text("utf-8")) for path in sorted(TEMPLATES.glob(f"*.{kind}"))
        )
        for kind in ("css", "js")
    )
    return {STYLE: styles, SCRIPT: scripts, ICON: (TEMPLATES / ICON).read_text("utf-8")}


def written(text: str | bytes, folder: Path, name: str) -> Path:
    """Write a page, or another file, into `folder` under `name`, whole or not at all, and return
    its path; raises OSError where the folder cannot be written."""
    folder.mkdir(parents=True, exist_ok=True)
    # A file in a folder has the permissions that the user's umask leaves, unlike a temporary file.
    with tempfile.TemporaryDirectory(prefix=".plumbob-", dir=folder) as scratch:
        part = Path(scratch) / name
        part.write_bytes(text.encode("utf-8") if isinstance(text, str) else text)
        os.replace(part, folder / name)
    return folder / name


def figure_json(figure: Figure) -> str:
    """A figure's traces and layout as JSON that no HTML parser takes for a tag; x and y are places
    in a list of arrays, since many methods share their times and some their errors."""
    arrays: dict[str, int] = {}
    traces = [
        {key: _once(value, arrays) if key in "xy" else value for key, value in trace.items()}
        for trace in figure.traces
    ]
    encoded = _json({"data": traces, "layout": figure.layout})
    text = f'{{"arrays":[{",".join(arrays)}],{encoded[1:]}'
    return text.replace("<", "\\u003c")


def _json(values: Any) -> str:
    return json.dumps(values, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def _once(values: Any, arrays: dict[str, int]) -> int:
    """The place of an array among `arrays`, where it stands once."""
    return arrays.setdefault(_json(values), len(arrays))


def _same_page(place: str) -> str:
    """The address of a place on a page that stands alone."""
    return f"#{place}"
