"""A page filled with its content: one file with everything, or one of several that share files."""

from __future__ import annotations

import base64
import gzip
import json
import os
import re
import tempfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.reports.view import compiled_templates
from plumbob.reports.view.content import Figure

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

TEMPLATES = Path(__file__).parent / "templates"
NAME = "index.html"
UNITS = re.compile(r"(?<=\d) (?=(?:%|m?s|[nµmk]?m|rad|N|J|W|°)(?![\w]))")  # no line ends before one
EXPONENT = re.compile(r"-?\d[\d.]*e-\d+")  # a line may end after a hyphen
STYLE, SCRIPT, PLOTLY, ICON = "page.css", "page.js", "plotly.js", "icon.svg"


def filled(template: str, *, shared: str | None = None, **content: Any) -> str:
    """A template of a page filled with its content. With `shared`, the path to the folder of a
    site, the page loads the files of `shared_files` from there; without, it holds them."""
    from markupsafe import Markup

    inside = {name: Markup(text) for name, text in _inside().items()} if shared is None else {}
    defaults: dict[str, Any] = {
        "styles": {},
        "frame": "frame.html.jinja",
        "href": _same_page,
        "preview": None,
    }
    return (
        _environment()
        .get_template(template)
        .render({**defaults, **content, "shared": shared, "inside": inside})
    )


@cache
def _environment() -> Environment:
    """The environment that reads the templates and caches them."""
    from markupsafe import Markup

    environment = compiled_templates.environment(TEMPLATES, autoescape=True)
    environment.filters["kept"] = _kept
    environment.filters["figure_json"] = lambda figure: Markup(figure_json(figure))
    return environment


def _kept(text: str) -> Markup:
    """A text in which no line ends inside a number, or before its unit."""
    from markupsafe import Markup, escape

    escaped = str(escape(UNITS.sub("\u00a0", text)))
    return Markup(EXPONENT.sub(r"<span class=nowrap>\g<0></span>", escaped))


def shared_files() -> dict[str, str]:
    """The style sheet, our script, plotly and the icon, by name: what all pages of a site load."""
    from plotly.offline import get_plotlyjs

    styles, scripts = (
        "\n".join(path.read_text("utf-8") for path in sorted(TEMPLATES.glob(f"*.{kind}")))
        for kind in ("css", "js")
    )
    icon = (TEMPLATES / ICON).read_text("utf-8")
    return {STYLE: styles, SCRIPT: scripts, PLOTLY: get_plotlyjs(), ICON: icon}


@cache
def _inside() -> dict[str, str]:
    """The same for a page that holds them: plotly compressed, in base64, which our script unpacks
    when a plot is near."""
    files = shared_files()
    packed = base64.b64encode(gzip.compress(files[PLOTLY].encode("utf-8"), mtime=0))
    return {**files, PLOTLY: packed.decode("ascii")}


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
