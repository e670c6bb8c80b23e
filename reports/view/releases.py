"""The results of each release of an engine side by side: rows of the terminal's table, and the
page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plumbob.engines.audit.changes import audited_file
from plumbob.engines.releases.measuring import Release
from plumbob.reports.judge.release_changes import ReleaseChange
from plumbob.reports.records.notation import metres
from plumbob.reports.records.page_records import records_of
from plumbob.reports.view.method_results import results_of
from plumbob.reports.view.page import fill_page, write_file
from plumbob.reports.view.tables import paragraphs, table, table_or_none

NO_RESULT = "–"


@dataclass(frozen=True)
class ReleaseRow:
    """The results of all releases on one scene or model file."""

    subject: str  # names of a scene and a method, or the path of a model file
    cells: tuple[str, ...]  # error with each release, as text
    costs: tuple[float | None, ...]  # ratios of a step's time to a reference step's time


def release_rows(releases: Sequence[Release]) -> list[ReleaseRow]:
    """Returns a row for each scene and method, and for each model file."""
    columns = [{**_scene_cells(release), **_model_cells(release)} for release in releases]
    subjects = dict.fromkeys(subject for column in columns for subject in column)
    rows = []
    for subject in subjects:
        found = [column.get(subject, (NO_RESULT, None)) for column in columns]
        texts, costs = zip(*found, strict=True)
        rows.append(ReleaseRow(subject, texts, costs))
    return rows


def _scene_cells(release: Release) -> dict[str, tuple[str, float | None]]:
    """Returns {scene and method: (relative error at the reference step as text, cost of a step in
    reference steps)} of a release."""
    study = release.study
    if study is None:
        return {}
    cells = {}
    for (scene, method), result in results_of(study, records_of(study)).items():
        shown = result.at_reference
        text = shown.text if shown else result.judged.verdict
        cost = result.cost.ns_per_step / study.reference_step if result.cost else None
        cells[f"{scene} {method}"] = (text, cost)
    return cells


def _model_cells(release: Release) -> dict[str, tuple[str, float | None]]:
    """Returns {path of a model file: (its error as text, None)} of a release."""
    cells = dict[str, tuple[str, float | None]]()
    for audit in release.audits:
        error = audit.get("error")
        if "fields" not in audit:
            text = "refused"
        elif error is None:
            text = "not certified"
        else:
            text = f"{metres(error)} at {audit['certified_until']:.3g} s"
        cells[audited_file(audit)] = (text, None)
    return cells


def write_releases(
    folder: Path,
    name: str,
    releases: Sequence[Release],
    rows: Sequence[ReleaseRow],
    changes: Sequence[ReleaseChange],
    moved: Sequence[ReleaseChange],
    command: str,
) -> Path:
    """Writes the page of the releases into a folder, whole or not at all, and returns its path.
    `moved` are the results that moved, of all `changes`; `command` reproduces the page."""
    marked = {(change.version, change.subject) for change in moved}
    tables: list[Any] = [
        table_or_none("releases", releases=releases, rows=rows, marked=marked),
        table_or_none("release_changes", caption="Results that moved", rows=moved),
        table_or_none(
            "release_changes",
            caption="What the release reads in another way",
            rows=[change for change in changes if change.explains],
        ),
    ]
    text = fill_page(
        "releases.html.jinja",
        lead=" ".join(paragraphs("releases", releases=releases, moved=moved)),
        overview=table("overlays", releases=releases),
        tables=[written for written in tables if written],
        command=command,
    )
    return write_file(text, folder, name)
