"""The page of a contact audit: its answer, distances over the heading, errors against the step."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from plumbob.engines.audit.contacts import HEADINGS, ContactAudit, Measured
from plumbob.reports.view.audit.contacts import contact_rows, per_cent
from plumbob.reports.view.audit.page import COLOURS, laid_out, page_name
from plumbob.reports.view.audit.text import duration, length
from plumbob.reports.view.content import Cell, Figure, Table
from plumbob.reports.view.page import written
from plumbob.reports.view.palette import GREY
from plumbob.reports.view.traces import curve, figure, linear, logarithmic

KINDS = ("your contacts", "pasted contacts")


def write_contact_page(
    audit: ContactAudit, folder: Path, command: str, drawn: bytes | None = None
) -> Path:
    """Write the page of a contact audit into `folder`, whole or not at all, and return its path;
    `command` is what reproduces it, `drawn` a PNG of the model. Raises OSError where the folder
    cannot be written."""
    name = page_name(audit.name, folder, "-contacts.html")
    return written(render_contacts(audit, command, drawn), folder, name)


def render_contacts(audit: ContactAudit, command: str, drawn: bytes | None = None) -> str:
    """The page of a contact audit as HTML; `drawn` is a PNG of the model."""
    return laid_out(
        model=audit.name,
        title=f"how wrong are the contacts of {audit.name}",
        heading=f"How wrong are the contacts of {audit.name}?",
        lead="The body of the model on its own feet and plane, as one rigid piece: it slides, "
        "turns and is pushed under the contact settings of the file, and under those that plumbob "
        "settings prints. Coulomb's law determines where a body stops that slides without turning.",
        answer=contact_rows(audit),
        figures=(distances_figure(audit), errors_figure(audit)),
        tables=(distances_table(audit),),
        code=audit.snippet,
        drawn=drawn,
        command=command,
        seconds=audit.seconds,
    )


def distances_figure(audit: ContactAudit) -> Figure:
    """Stopping distances at the own step over the heading."""
    degrees = [math.degrees(h) for h in HEADINGS]
    traces = [
        curve(degrees, runs[0].distances, colour=colour, name=name, marks=True)
        for (name, runs), colour in zip(_runs(audit), COLOURS, strict=False)
        if runs
    ]
    name = "Coulomb" if audit.exact is not None else "what the pasted contacts tend to"
    traces.append(curve(degrees, audit.distances, colour=GREY, dash="dot", name=name, width=3.0))
    return figure(
        "Stopping distance over the heading",
        f"The body starts at {audit.speed:g} m/s without turning. Friction that follows Coulomb's "
        "law is the same in all directions.",
        traces,
        linear("heading from the plane's x axis [°]", dtick=45),
        linear("stopping distance [m]", rangemode="tozero"),
        legend=True,
    )


def errors_figure(audit: ContactAudit) -> Figure:
    """The largest error of a stopping distance against the step."""
    traces = []
    for (name, runs), colour in zip(_runs(audit), COLOURS, strict=False):
        shown = [(run.step, audit.error(run)) for run in runs]
        shown = [(h, e) for h, e in shown if math.isfinite(e) and e > 0.0]
        if shown:
            steps, errors = zip(*shown, strict=True)
            traces.append(curve(steps, errors, colour=colour, name=name, marks=True))
    predicted = [(run.step, audit.predicted(run)) for run in audit.pasted]
    largest = [(h, float(np.abs(e).max())) for h, e in predicted if e is not None]
    known = [(h, e) for h, e in largest if e > 0.0]
    if known:
        steps, errors = zip(*known, strict=True)
        traces.append(curve(steps, errors, colour=GREY, dash="dot", name="predicted", width=3.0))
    return figure(
        "Error against the time step",
        "The largest error of a stopping distance over all headings. Contacts that converge with "
        "the step fall to the left; the pasted ones are written anew for each step.",
        traces,
        logarithmic("time step [s]"),
        logarithmic("error [m]"),
        legend=True,
    )


def distances_table(audit: ContactAudit) -> Table:
    """Stopping distances and their errors, by heading."""
    rows = []
    for k, heading in enumerate(HEADINGS):
        cells = [Cell(f"{math.degrees(heading):.0f}°", "number")]
        compared = float(audit.distances[k])
        for _, runs in _runs(audit):
            cells += _cells(runs[0], k, compared) if runs else [Cell("not run"), Cell("")]
        cells.append(Cell("not determined" if math.isnan(compared) else length(compared), "number"))
        rows.append(tuple(cells))
    heads = ("heading", *(h for name in KINDS for h in (name, "error")), "compared with")
    return Table(f"Stopping distances at {duration(audit.step)}", heads, tuple(rows), folded=True)


def _cells(run: Measured, k: int, compared: float) -> list[Cell]:
    slide = run.slides[k]
    error = "" if math.isnan(compared) else per_cent(slide.along - compared, compared)
    stops = length(abs(slide.along)) if slide.rests else "does not stop"
    return [Cell(stops, "number"), Cell(error if slide.rests else "", "number")]


def _runs(audit: ContactAudit) -> tuple[tuple[str, tuple[Measured, ...]], ...]:
    return (KINDS[0], audit.own), (KINDS[1], audit.pasted)
