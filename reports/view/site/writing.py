"""The site of a study: pages in a folder of their own, then the index that leads to them."""

from __future__ import annotations

import base64
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from plumbob.engines.study.results import Study
from plumbob.reports.view import top_tables
from plumbob.reports.view.drawing import DASHES
from plumbob.reports.view.method_results import SIGNS, Results, results_of
from plumbob.reports.view.own_files import LIST, replaceable, replaceable_folder
from plumbob.reports.view.page import (
    NAME,
    Plots,
    carried,
    encoded,
    filled,
    packed,
    shared_files,
    written,
)
from plumbob.reports.view.palette import styles
from plumbob.reports.view.records import Records, records_of
from plumbob.reports.view.settings import pasted
from plumbob.reports.view.site import first_screen, matrix, search
from plumbob.reports.view.site.claims import formed
from plumbob.reports.view.site.largest_step import largest_step
from plumbob.reports.view.site.links import INDEX, PAGES, address, linked, places_of
from plumbob.reports.view.site.phenomena import phenomena
from plumbob.reports.view.site.views import OF_ENGINES, View, system_view
from plumbob.reports.view.user_settings import table as own_table

SMOOTH = (
    "cone-pendulum/rotating-base"  # scene without contacts whose cost figure is on the index
)
GRADIENTS = "gradients-through-contact"  # finding whose picture is on the index
BESIDE = MappingProxyType(
    {
        OF_ENGINES: "on_engines",
        "cheapest": "advice",
        "sources": "sources",
        "glossary": "terms",
    }
)  # pages that belong to no system, each with the common value without which it is left out
SEARCH = "search.js"
BARE, FRAME = "bare.html.jinja", "frame.html.jinja"
Page = tuple[str, str, dict[str, Any]]  # name of the page, its template, values of the template


@dataclass(frozen=True)
class Content:
    """The content of all pages of a study's site."""

    common: dict[str, Any]  # values that every page may show, by name
    pages: Sequence[Page]  # all pages but the index


def write_page(study: Study, folder: Path) -> Path:
    """Writes the site of `study` into `folder` and returns the path of its index.

    The new folder of pages replaces the old one in one move, and the index follows. Raises OSError
    if `folder` cannot be written, ParameterError if it would replace a file that plumbob did not
    write, and the errors of `records_of`."""
    return site(content(study), folder)


def site(content: Content, folder: Path) -> Path:
    """Writes the site with this content into `folder` and returns the path of its index; raises
    OSError and ParameterError as `write_page` does."""
    own_site("out", folder)
    files, index = _files(content)
    files = {**files, LIST: "".join(f"{name}\n" for name in files)}
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".plumbob-", dir=folder) as scratch:
        new = Path(scratch) / PAGES
        pages = folder / PAGES
        new.mkdir()  # with the permissions of the user's umask, unlike the temporary folder
        for name, text in files.items():
            (new / name).write_bytes(encoded(text))
        if pages.is_dir():
            pages.rename(Path(scratch) / "old")
        new.rename(pages)
    return written(index, folder, NAME)


def own_site(name: str, folder: Path) -> None:
    """Raises ParameterError, naming the option `name`, if the site would replace a file in `folder`
    that plumbob did not write."""
    replaceable(name, folder / NAME)
    replaceable_folder(name, folder / PAGES)


def one_file(content: Content) -> str:
    """Returns the whole site as one HTML text. All pages but the index are HTML templates inside
    the index, which the page's script shows on demand."""
    common = content.common
    inside = [
        (name, filled(template, shared="", single=True, frame=BARE, **common, **values))
        for name, template, values in content.pages
    ]
    entries = packed(search.entries_text(common, "#{}".format))
    return filled("index.html.jinja", inside_pages=inside, search=entries, **common)


def _files(content: Content) -> tuple[Mapping[str, str | bytes], str]:
    """Returns the files of the site's folder of pages, by file name, and the text of the index."""
    common = content.common
    texts = dict[str, str]()
    files: dict[str, str | bytes] = dict(shared_files())
    for name in {view.system.picture for view in common["views"]} - {""}:
        files[name] = base64.b64decode(common["pictures"][name])
    plots = {INDEX: Plots(f"{PAGES}/", INDEX)}
    for name, template, values in (
        (INDEX, "index.html.jinja", {"inside_pages": ()}),
        *content.pages,
    ):
        drawn = plots.setdefault(name, Plots("", name))
        more = common | values
        texts[name] = filled(template, shared=drawn.folder, plots=drawn, search="", **more)
    places = places_of(texts)
    files[SEARCH] = carried(search.entries_text(common, partial(address, places)))
    for name, text in texts.items():
        files[f"{name}.html"] = linked(places, text, name)
        files |= plots[name].files
        if plots[name].data or plots[name].tables:
            files[f"{name}.js"] = carried(linked(places, plots[name].text(), name))
    index = files.pop(NAME)
    return files, str(index)


def content(study: Study) -> Content:
    """Returns the content of the pages of `study`; raises the errors of `records_of`."""
    records = records_of(study)
    every = results_of(study, records)
    asked = {scene for scene, _ in every}  # a scene is missing if no method was meant for it
    study = replace(study, scenes=tuple(s for s in study.scenes if s.name in asked))
    views = _views(study, records, every)
    common = _common(study, records, views, every)
    return Content(common, _pages(views, common))


def _views(study: Study, records: Records, every: Results) -> list[View]:
    """Returns the view of each system of the study, in the order of the sources. A system of
    another package is left out if no run of it reached its end."""
    done = {
        c.scene for c in study.convergence if any(m.status == "done" for m in c.measurements)
    }
    ran = {scene.system for scene in study.scenes if scene.name in done}
    # If no run was compared with another package's exact motion, that motion may be defective.
    here = {scene.system for scene in study.scenes}
    systems = {s.name: s for s in records.study.systems if s.name in (ran if s.added else here)}
    return [
        system_view(study, records, systems[name], every)
        for name in sorted(systems, key=matrix.rank)
    ]


def _common(
    study: Study, records: Records, views: Sequence[View], every: Results
) -> dict[str, Any]:
    """Returns the values that every page may show, by their names in the templates."""
    on_engines = formed(study, OF_ENGINES)
    findings = [*(finding for view in views for finding in view.findings), *on_engines]
    answers = first_screen.answers(study, records.study, every)
    by_engine = first_screen.by_engine(every)
    shown = {answer.pasted.settings.method for answer in answers}
    advice = {name: record.recommendations for name, record in records.scenes.items()}
    settings = [s for s in pasted(records.study.settings) if s.settings.method not in shown]
    recommendations = top_tables.recommendations(study, advice)
    return {
        "study": study,
        "views": views,
        "findings": findings,
        "on_engines": on_engines,
        "cards": first_screen.cards(findings),
        "gradients": first_screen.cards([f for f in findings if f.name == GRADIENTS]),
        "preview": next((view.system.picture for view in views if view.system.picture), ""),
        "counts": sum(by_engine.values(), Counter()),
        "by_engine": by_engine,
        "made": first_screen.made(every),
        "answers": answers,
        "smooth": next(
            (of for view in views for of in view.scenes if of.scene.name == SMOOTH), None
        ),
        "largest_step": largest_step(every),
        "settings": settings,
        "advice": recommendations or settings,
        "user_settings": own_table(records.study.user, every),
        "matrices": matrix.matrices(study, every, matrix.ordered(study.scenes)),
        "phenomena": phenomena(study, every, records.study.systems),
        "signs": dict(SIGNS),
        "engines": {
            engine: matrix.ENGINES.get(engine, engine) for engine in matrix.engines(study)
        },
        "recommendations": recommendations,
        "sources": top_tables.sources(findings),
        "every_statement": top_tables.every_statement(findings),
        "styles": styles(m.name for m in study.methods),
        "dashes": dict(DASHES),
        "provenance": study.provenance,
        "pictures": records.study.pictures,
        "terms": search.defined("glossary"),
        "labels": search.defined("labels"),
        "place_of": search.place_of,
    }


def _pages(views: Sequence[View], common: Mapping[str, Any]) -> list[Page]:
    """Returns all pages but the index: systems, scenes, then the pages that belong to no system."""
    pages: list[Page] = [
        *((view.system.name, "system.html.jinja", {"view": view}) for view in views),
        *(
            (scene.anchor, "scene.html.jinja", {"view": scene, "of": view})
            for view in views
            for scene in view.scenes
        ),
    ]
    there = [name for name, needed in BESIDE.items() if common[needed]]
    return [*pages, *((name, f"{name}.html.jinja", {}) for name in there)]
