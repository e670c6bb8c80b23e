"""A page read by a test, without running its scripts, and the commands in a text."""

import base64
import gzip
import json
import re
import shlex
from functools import cache
from html.parser import HTMLParser

from plumbob.engines.registry import method as find_method
from plumbob.engines.registry import methods as find_methods
from plumbob.models.registry import matching_scenes as find_scenes
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import systems
from plumbob.reports.cli import COMMANDS, parser
from plumbob.reports.commands.arguments.options import read_values
from plumbob.reports.commands.settings import FOR


class Document(HTMLParser):
    """Parts of a page for tests: ids, links, loaded files, plots, and the text of tables."""

    def __init__(self, text):
        super().__init__()
        self.ids = []
        self.links = []
        self.loaded = []
        self.scripts = []
        self.cells = []
        self.tags = []
        self._inside = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.tags.append(tag)
        self.ids += [given["id"] or ""] if "id" in given else []
        self.links += [given["href"] or ""] if tag == "a" else []
        self.loaded += [
            given[name] or "" for name in ("src", "srcset", "data", "data-src") if name in given
        ]
        self.loaded += [given["href"] or ""] if tag in ("link", "image") else []
        self._inside = tag
        if tag in ("td", "th"):
            self._inside = "td"
            self.cells.append("")

    def handle_endtag(self, tag):
        self._inside = (
            "td" if tag in ("a", "span", "svg", "button") and self._inside != "" else ""
        )

    def handle_data(self, data):
        if self._inside == "script":
            self.scripts.append(data)
        elif self.cells:
            self.cells[-1] += data


def site_files(index):
    """The pages of a site: its index, and those in the folder that it leads to."""
    return [index, *sorted((index.parent / "pages").glob("*.html"))]


def plotted(file):
    """The figures of a page of a site, as plotly takes them."""
    holder = re.search(r'class="figures" data-src="([^"]+)"', file.read_text("utf-8"))
    if holder is None:
        return []
    return json.loads(carried_text(file.parent / holder[1]))["figures"]


def folded(file):
    """The folded tables that a page of a site shows when they are wanted, as HTML."""
    holder = re.search(r'class="figures" data-src="([^"]+)"', file.read_text("utf-8"))
    return json.loads(carried_text(file.parent / holder[1]))["tables"] if holder else []


def plotted_inside(page):
    """The same of a page that holds them."""
    (text,) = re.findall(r'class="figures">([^<]+)<', page)
    return unpacked_text(text)["figures"]


def carried_text(file):
    """The text that a script beside a page holds compressed."""
    return gzip.decompress(base64.b64decode(file.read_text("utf-8").split('"')[1])).decode()


def unpacked_text(text):
    """What a page holds as compressed JSON."""
    return json.loads(gzip.decompress(base64.b64decode(text)))


def broken_links(documents):
    """Links of these pages that lead to no page or to no place on it, nor to a system's source; and
    ids that stand twice."""
    sources = " ".join(scene.source for system in systems().values() for scene in system.scenes)
    outside = set(re.findall(r"https://\S+", sources))
    ids = {file.resolve(): set(document.ids) for file, document in documents.items()}
    broken = []
    for file, document in documents.items():
        twice = len(document.ids) - len(set(document.ids))
        broken += [f"{file.name}: {twice} ids stand twice"] if twice else []
        for link in dict.fromkeys(one for one in document.links if one not in outside):
            path, _, place = link.partition("#")
            found = (file.parent / path).resolve() if path else file.resolve()
            there = found in ids or (found.is_file() and found.suffix != ".html")
            if not there or (place and place not in ids[found]):
                broken.append(f"{file.name}: {link}")
    return broken


def words(command):
    """What follows `plumbob` in a command as a text has it, without its comment."""
    first, *rest = shlex.split(command, comments=True)
    assert first == "plumbob", command
    return rest


@cache
def _parser():
    """The command line's parser, made once for hundreds of commands."""
    return parser(COMMANDS)


def resolve(command, folder):
    """Raises SystemExit, ParameterError or AssertionError unless a command can be read, and its
    scenes, methods, numbers, and files in `folder` are there, but a reader's `my.xml`; runs
    nothing."""
    chosen = _parser().parse_args(words(command))
    read_values(chosen)
    given = vars(chosen)
    if "scenes" in given:
        found = find_scenes(chosen.scenes or "*", chosen.profile)
        assert found, command
        assert find_methods(chosen.methods or "*"), command
    elif "scene" in given and chosen.scene.endswith(".xml"):
        assert chosen.scene == "my.xml" or (folder / chosen.scene).is_file(), command
    elif "scene" in given:
        changed = given.get("changes", {})
        pattern = chosen.scene if any(c in chosen.scene for c in "*?[") else ""
        assert find_scenes(pattern) if pattern else find_scene(chosen.scene, changed), command
    if given.get("method") not in (None, [], FOR):
        several = isinstance(chosen.method, list)
        assert find_methods(",".join(chosen.method)) if several else find_method(chosen.method)
    if "like" in given and chosen.like:
        assert (folder / chosen.like).is_file(), command
