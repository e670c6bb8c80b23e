"""HTML pages from templates: either one file with everything, or pages of a site that share
files."""

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
from types import MappingProxyType
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from plumbob.reports.records import notation
from plumbob.reports.view.content import Figure
from plumbob.reports.view.drawing import SvgDrawing, svg_drawing
from plumbob.reports.view.own_files import check_replaceable
from plumbob.reports.view.tables import template_environment

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

PAGE_TEMPLATES = Path(__file__).parents[1] / "templates" / "site"
INDEX_PAGE = "index.html"
# no line ends before one
SPACE_BEFORE_UNIT = re.compile(r"(?<=\d) (?=(?:%|m?s|[nµmck]?m|rad|N|J|W|°)(?![\w]))")
INDENT = re.compile(r"^ +(?:// .*\n)?", re.MULTILINE)  # indents and comments of a script
CODE = re.compile("`([^`]+)`")
# A symbol in the text of HTML, outside of tags: with a subscript, such as I_z, or with dots over it
SUBSCRIPT = re.compile(r"\b([A-Z])_([a-z]{1,2})\b(?=[^<>]*<)")
DOTTED = re.compile("(\\w)([\u0307\u0308])(?=[^<>]*<)")
DOTS = MappingProxyType({"\u0307": "˙", "\u0308": "¨"})
EXPONENT = re.compile(r"-?\d[\d.]*e-\d+")  # a line may end after a hyphen
URL_CHARACTERS = " =/:;,.()'-{}!*"  # characters that need no escape in a data URL
STYLE, SCRIPT, PLOTLY, ICON = "page.css", "page.js", "plotly.js", "icon.svg"


def filled_picture(drawn: SvgDrawing) -> str:
    """Returns a drawing as the text of an SVG file."""
    return _environment().get_template("figure.svg.jinja").render(of=drawn)


@dataclass(frozen=True)
class Plots:
    """The parts of one page that its script shows on demand, collected while the template is
    filled: pictures, the data of plotly's figures, folded tables and the data of a replay."""

    # path from the page to the files; None: everything is in the page
    folder: str | None = None
    page: str = ""  # name of the page
    # data and layout of each figure in plotly's format
    data: list[Mapping[str, Any]] = field(default_factory=list)
    tables: list[str] = field(default_factory=list)  # HTML of each folded table
    files: dict[str, str] = field(default_factory=dict)  # texts by file name

    def picture(
        self, figure: Figure, chosen: Sequence[str], still: bool = False
    ) -> tuple[str, SvgDrawing | None]:
        """Returns the address and the drawing of a figure's picture; "" and None if nothing can be
        drawn. The picture shows the `chosen` methods if the figure has any of them.

        A click on the picture lets plotly draw the figure anew. A `still` picture has no such data.
        It is never wide, because it stands in a column, and the page itself holds it, so that the
        first screen needs no further file."""
        if not still:
            self.data.append({"data": figure.traces, "layout": figure.layout})
        drawn = svg_drawing(replace(figure, wide=figure.wide and not still), chosen)
        if drawn is None:
            return "", None
        svg = filled_picture(drawn)
        if self.folder is None or still:
            return f"data:image/svg+xml,{quote(svg, safe=URL_CHARACTERS)}", drawn
        name = f"{hashlib.sha256(svg.encode('utf-8')).hexdigest()[:12]}.svg"
        self.files[name] = svg
        return f"{self.folder}{name}", drawn

    def script(self) -> str:
        """Returns the compressed data of figures and tables or, for a page of a site, the address
        of the script that will hold them."""
        return compress(self.text()) if self.folder is None else f"{self.folder}{self.page}.js"

    def text(self) -> str:
        """Returns the data of figures and tables as JSON."""
        return _json({"figures": self.data, "tables": list(map(with_mathml, self.tables))})

    def beside(self, name: str, text: str) -> str:
        """Returns the compressed text or, for a page of a site, stores it as the script
        `NAME.js` and returns the address of that script."""
        if self.folder is None:
            return compress(text)
        self.files[f"{name}.js"] = carrier_script(text)
        return f"{self.folder}{name}.js"


def compress(text: str) -> str:
    """Returns a text compressed, in base64; the page's script unpacks it on demand."""
    return base64.b64encode(gzip.compress(text.encode("utf-8"), 4, mtime=0)).decode("ascii")


def carrier_script(text: str) -> str:
    """Returns a script that writes the compressed text into its own element. A page opened from a
    folder can load scripts, but no other data."""
    return f'document.currentScript.textContent="{compress(text)}"'


def fill_page(
    template: str, *, shared: str | None = None, plots: Plots | None = None, **content: Any
) -> str:
    """Returns the HTML of a page: the template filled with `content`.

    `shared` is the path from the page to the folder with `shared_files`; if it is None, the page
    holds these files itself. The files and data of the page's figures are added to `plots`."""
    from markupsafe import Markup

    files = shared_files(compress) if shared is None else {}
    inside = {name: Markup(text) for name, text in files.items()}
    defaults: dict[str, Any] = {
        "styles": {},
        "frame": "frame.html.jinja",
        "single": shared is None,
        "preview": None,
        "search": None,
        "plots": plots or Plots(),
    }
    values = {**defaults, **content, "shared": shared, "inside": inside}
    return with_mathml(_environment().get_template(template).render(values))


def with_mathml(text: str) -> str:
    """Returns HTML in which symbols with subscripts or dots are MathML, which stays legible where
    letters are small."""
    text = SUBSCRIPT.sub(r"<math><msub><mi>\1</mi><mi>\2</mi></msub></math>", text)
    over = '<math><mover accent="true"><mi>{}</mi><mo>{}</mo></mover></math>'
    return DOTTED.sub(lambda symbol: over.format(symbol[1], DOTS[symbol[2]]), text)


@cache
def _environment() -> Environment:
    """Returns the environment of the page templates; it caches them."""
    pages = template_environment(PAGE_TEMPLATES, autoescape=True)
    pages.filters["kept"] = _unbroken
    pages.filters["numbers"] = lambda values: _json(dict(values))
    for write in (
        *(notation.number, notation.short, notation.seconds, notation.plural),
        *(notation.relative, notation.times_real),
    ):
        pages.globals[write.__name__] = write
    return pages


def _unbroken(text: str) -> Markup:
    """Returns a text as HTML in which no line breaks inside a number or between a number and its
    unit; text between backquotes becomes code."""
    from markupsafe import Markup, escape

    escaped = str(escape(SPACE_BEFORE_UNIT.sub("\u00a0", text)))
    unbroken = EXPONENT.sub(r"<span class=nowrap>\g<0></span>", escaped)
    return Markup(CODE.sub(r"<code class=inline>\1</code>", unbroken))


@cache
def shared_files(hold: Callable[[str], str] = carrier_script) -> Mapping[str, str]:
    """Returns the files that all pages share, by name: the style sheet, the script, plotly wrapped
    by `hold`, and the icon."""
    from plotly.offline import get_plotlyjs

    return {
        STYLE: _joined_files("css"),
        SCRIPT: _joined_files("js"),
        PLOTLY: hold(get_plotlyjs()),
        ICON: (PAGE_TEMPLATES / ICON).read_text("utf-8"),
    }


def _joined_files(suffix: str) -> str:
    """Returns the text of all templates with a suffix, without indents and comment lines."""
    paths = sorted(PAGE_TEMPLATES.glob(f"*.{suffix}"))
    return "\n".join(INDENT.sub("", path.read_text("utf-8")) for path in paths)


def write_file(text: str | bytes, folder: Path, name: str) -> Path:
    """Writes a file into `folder` under `name`, whole or not at all, and returns its path. Raises
    OSError if the folder cannot be written, and ParameterError if the file would replace one that
    plumbob did not write."""
    check_replaceable("out", folder / name)
    folder.mkdir(parents=True, exist_ok=True)
    # A file in a temporary folder gets the permissions of the user's umask; a temporary file does
    # not.
    with tempfile.TemporaryDirectory(prefix=".plumbob-", dir=folder) as scratch:
        part = Path(scratch) / name
        part.write_bytes(to_bytes(text))
        os.replace(part, folder / name)
    return folder / name


def to_bytes(text: str | bytes) -> bytes:
    """Returns the content of a file as UTF-8 bytes. Names of files in the text may hold bytes that
    are no characters: these are escaped."""
    return text.encode("utf-8", "backslashreplace") if isinstance(text, str) else text


def _json(values: Any) -> str:
    """Returns values as compact JSON; raises ValueError for a number that is not finite."""
    return json.dumps(values, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
