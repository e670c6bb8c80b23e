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
from plumbob.reports.records.page_records import ENGINES_SECTION, Records, records_of
from plumbob.reports.view import top_tables
from plumbob.reports.view.audit.html import sample_audit
from plumbob.reports.view.method_results import SIGNS, Results, results_of
from plumbob.reports.view.own_files import (
    FILE_LIST,
    check_replaceable,
    check_replaceable_folder,
)
from plumbob.reports.view.page import (
    INDEX_PAGE,
    Plots,
    carrier_script,
    compress,
    fill_page,
    shared_files,
    to_bytes,
    write_file,
)
from plumbob.reports.view.palette import styles
from plumbob.reports.view.settings import shown_settings
from plumbob.reports.view.site import first_screen, matrix, search
from plumbob.reports.view.site.chooser import chooser_options, simulated_kinds
from plumbob.reports.view.site.claims import findings_about
from plumbob.reports.view.site.largest_step import largest_step_table
from plumbob.reports.view.site.links import (
    INDEX,
    PAGES,
    pages_by_id,
    relative_address,
    resolve_links,
)
from plumbob.reports.view.site.phenomena import phenomena
from plumbob.reports.view.site.side_by_side import side_by_side
from plumbob.reports.view.site.system_cards import thumbnails
from plumbob.reports.view.site.views import PageView, system_view
from plumbob.reports.view.user_settings import user_settings_table as own_table

GRADIENTS_FINDING = "gradients-through-contact"  # finding whose picture is on the index
SHARED_PAGES = MappingProxyType(
    {
        ENGINES_SECTION: "engines_page",
        "cheapest": "advice",
        "sources": "sources",
        "glossary": "terms",
    }
)
"""{page that belongs to no system: name of the common value that it needs}. A page whose value is
missing is left out."""
SAMPLE_PAGE = "audit"  # page of the sample audit, to which the choice on the index leads
SEARCH = "search.js"
BARE_TEMPLATE = "bare.html.jinja"
Page = tuple[str, str, dict[str, Any]]  # name of the page, its template, values of the template


@dataclass(frozen=True)
class SiteContent:
    """The content of all pages of a study's site."""

    common: dict[str, Any]  # values that every page may show, by name
    pages: Sequence[Page]  # all pages but the index


def write_study_pages(study: Study, folder: Path) -> Path:
    """Writes the site of `study` into `folder` and returns the path of its index.

    The new folder of pages replaces the old one in one move, and the index follows. Raises OSError
    if `folder` cannot be written, ParameterError if it would replace a file that plumbob did not
    write, and the errors of `records_of`."""
    return write_site(site_content(study), folder)


def write_site(content: SiteContent, folder: Path) -> Path:
    """Writes the site with this content into `folder` and returns the path of its index; raises
    OSError and ParameterError as `write_study_pages` does."""
    check_site_replaceable("out", folder)
    files, index = _files(content)
    files = {**files, FILE_LIST: "".join(f"{name}\n" for name in files)}
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".plumbob-", dir=folder) as scratch:
        new = Path(scratch) / PAGES
        pages = folder / PAGES
        new.mkdir()  # with the permissions of the user's umask, unlike the temporary folder
        for name, text in files.items():
            (new / name).write_bytes(to_bytes(text))
        if pages.is_dir():
            pages.rename(Path(scratch) / "old")
        new.rename(pages)
    return write_file(index, folder, INDEX_PAGE)


def check_site_replaceable(name: str, folder: Path) -> None:
    """Raises ParameterError, naming the option `name`, if the site would replace a file in `folder`
    that plumbob did not write."""
    check_replaceable(name, folder / INDEX_PAGE)
    check_replaceable_folder(name, folder / PAGES)


def site_in_one_file(content: SiteContent) -> str:
    """Returns the whole site as one HTML text. All pages but the index are HTML templates inside
    the index, which the page's script shows on demand."""
    common = content.common
    inside = [
        (
            name,
            fill_page(
                template, shared="", single=True, frame=BARE_TEMPLATE, **common, **values
            ),
        )
        for name, template, values in content.pages
    ]
    entries = compress(search.entries_text(common, "#{}".format))
    return fill_page("index.html.jinja", inside_pages=inside, search=entries, **common)


def _files(content: SiteContent) -> tuple[Mapping[str, str | bytes], str]:
    """Returns the files of the site's folder of pages, by file name, and the text of the index."""
    common = content.common
    texts = dict[str, str]()
    files: dict[str, str | bytes] = dict(shared_files())
    for name in {view.system.picture for view in common["views"]} - {""}:
        files[name] = base64.b64decode(common["pictures"][name])
    plots = {INDEX: Plots(f"{PAGES}/", INDEX)}
    index_page: Page = (INDEX, "index.html.jinja", {"inside_pages": ()})
    for name, template, page_values in (index_page, *content.pages):
        page_plots = plots.setdefault(name, Plots("", name))
        values = common | page_values
        texts[name] = fill_page(
            template, shared=page_plots.folder, plots=page_plots, search="", **values
        )
    places = pages_by_id(texts)
    files[SEARCH] = carrier_script(
        search.entries_text(common, partial(relative_address, places))
    )
    for name, text in texts.items():
        files[f"{name}.html"] = resolve_links(places, text, name)
        files |= plots[name].files
        if plots[name].data or plots[name].tables:
            files[f"{name}.js"] = carrier_script(
                resolve_links(places, plots[name].text(), name)
            )
    index = files.pop(INDEX_PAGE)
    return files, str(index)


def site_content(study: Study) -> SiteContent:
    """Returns the content of the pages of `study`; raises the errors of `records_of`."""
    records = records_of(study)
    results = results_of(study, records)
    # Scenes for which none of the study's methods is meant have no results, and no place on pages.
    with_results = {scene for scene, _ in results}
    study = replace(study, scenes=tuple(s for s in study.scenes if s.name in with_results))
    views = _views(study, records, results)
    common = _common(study, records, views, results)
    return SiteContent(common, _pages(views, common))


def _views(study: Study, records: Records, results: Results) -> list[PageView]:
    """Returns the view of each system of the study, in the order of their records. A system of
    another package is left out if no run of it reached its end."""
    done = {
        series.scene
        for series in study.convergence
        if any(run.status == "done" for run in series.measurements)
    }
    systems_done = {scene.system for scene in study.scenes if scene.name in done}
    systems_asked = {scene.system for scene in study.scenes}
    shown = []
    for system in records.study.systems:
        # If no run was compared with another package's exact motion, that motion may be defective.
        if system.name in (systems_done if system.added else systems_asked):
            shown.append(system)
    return [system_view(study, records, system, results) for system in shown]


def _common(
    study: Study, records: Records, views: Sequence[PageView], results: Results
) -> dict[str, Any]:
    """Returns the values that every page may show, by their names in the templates."""
    on_engines = findings_about(study, ENGINES_SECTION)
    findings = [*(finding for view in views for finding in view.findings), *on_engines]
    pictures = [view.system.picture for view in views if view.system.picture]
    by_engine = first_screen.meanings_by_engine(results)
    settings = shown_settings(records.study.settings)
    advice = {name: record.recommendations for name, record in records.scenes.items()}
    recommendations = top_tables.recommendations(study, advice)
    sides = side_by_side(study, results, records.study.systems)
    return {
        "study": study,
        "views": views,
        "findings": findings,
        "on_engines": on_engines,
        "cards": first_screen.key_findings(findings),
        "thumbnails": thumbnails({v.system.name: v.card for v in views if v.card}),
        "gradients": first_screen.key_findings(
            [f for f in findings if f.name == GRADIENTS_FINDING]
        ),
        "preview": pictures[0] if pictures else "",
        "counts": sum(by_engine.values(), Counter()),
        "by_engine": by_engine,
        "too_large": matrix.too_large_steps(results),
        "made": first_screen.run_counts(results),
        "kinds": simulated_kinds(study, records),
        "options": chooser_options(),
        "largest_step": largest_step_table(results),
        "settings": settings,
        "advice": recommendations or settings,
        "user_settings": own_table(records.study.user, results),
        "matrices": matrix.matrices(
            study, results, matrix.sorted_scenes(study.scenes, records.study.systems)
        ),
        "sides": sides,
        "engines_page": bool(sides or on_engines),
        "phenomena": phenomena(study, results, records.study.systems),
        "signs": dict(SIGNS),
        "engines": {
            engine: matrix.ENGINE_TITLES.get(engine, engine)
            for engine in matrix.engine_names(study)
        },
        "recommendations": recommendations,
        "sources": top_tables.sources(findings),
        "every_statement": top_tables.every_statement(findings),
        "styles": styles(m.name for m in study.methods),
        "provenance": study.provenance,
        "pictures": records.study.pictures,
        "terms": search.defined_terms("glossary"),
        "labels": search.defined_terms("labels"),
        "commands": search.defined_terms("commands"),
        "place_of": search.term_id,
    }


def _pages(views: Sequence[PageView], common: Mapping[str, Any]) -> list[Page]:
    """Returns all pages but the index: systems, scenes, then the pages that belong to no system."""
    pages: list[Page] = [
        (view.system.name, "system.html.jinja", {"view": view}) for view in views
    ]
    for view in views:
        pages += [
            (scene.anchor, "scene.html.jinja", {"view": scene, "of": view})
            for scene in view.scenes
        ]
    pages += [
        (name, f"{name}.html.jinja", {})
        for name, value in SHARED_PAGES.items()
        if common[value]
    ]
    if common["kinds"]:
        pages.append((SAMPLE_PAGE, "audit.html.jinja", vars(sample_audit())))
    return pages
