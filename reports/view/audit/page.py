"""The page of an audit: its ten lines, errors over time and against cost, contacts, ablations."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.steps import Compared, StepError
from plumbob.reports.advice.work_precision import front
from plumbob.reports.view.audit.text import duration, length, rows, trim_effect
from plumbob.reports.view.content import Cell, Figure, Table, row
from plumbob.reports.view.page import filled, written
from plumbob.reports.view.palette import GREY
from plumbob.reports.view.traces import (
    Trace,
    curve,
    figure,
    linear,
    logarithmic,
    over_time,
    positive,
)

COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7")  # of integrators, and of steps
SHOWN = 4  # steps of the own integrator in the figure over time
MARK = re.compile(r'data-model="(\w+)"')
MOST_PAIRS = 24  # in the contact timeline


def write_audit_page(audit: Audit, folder: Path, command: str, drawn: bytes | None = None) -> Path:
    """Write the page of an audit into `folder`, whole or not at all, and return its path; `command`
    is what reproduces it, `drawn` a PNG of the model. Raises OSError where the folder cannot be
    written."""
    return written(render(audit, command, drawn), folder, page_name(audit.name, folder, ".html"))


def page_name(model: str, folder: Path, ending: str) -> str:
    """`audit-NAME` and `ending`, by the name of the file `model`, with as many of its folders as
    tell the page from those of other files there."""
    parts, mark = Path(model).resolve().with_suffix("").parts[1:], mark_of(model)
    names = ["-".join(("audit", *parts[-k:])) + ending for k in range(1, len(parts) + 1)]
    for name in names:
        page = folder / name
        marks = MARK.findall(page.read_text("utf-8", "replace")) if page.is_file() else []
        if marks in ([], [mark]):
            return name
    return names[-1]


def mark_of(model: str) -> str:
    """Digits made of a file's path, which tell its pages from those of another."""
    return f"{crc32(str(Path(model).resolve()).encode()):08x}"


def render(audit: Audit, command: str, drawn: bytes | None = None) -> str:
    """The page of an audit as HTML; `drawn` is a PNG of the model."""
    return laid_out(
        model=audit.name,
        title=f"how wrong is {audit.name}",
        heading=f"How wrong is {audit.name}?",
        lead="The model as it stands, on one motion. Its continuous motion, without time steps, is "
        "certified by two computations, and its own steps are compared with that. Nothing here "
        "says how near the model is to reality.",
        answer=rows(audit),
        figures=figures(audit),
        tables=tuple(table for table in (steps_table(audit), trims_table(audit)) if table),
        code="",
        drawn=drawn,
        command=command,
        seconds=audit.seconds,
    )


def laid_out(
    *,
    model: str,
    answer: Iterable[tuple[str, str]],
    drawn: bytes | None,
    seconds: float,
    **content: Any,
) -> str:
    """The page of any audit of `model` as HTML: its answer as pairs of a name and a text, a PNG of
    the model, the time it took [s], and what else its template shows."""
    return filled(
        "audit.html.jinja",
        mark=mark_of(model),
        answer=Table("The answer", ("", ""), tuple(row(n, Cell(t, "text")) for n, t in answer)),
        picture=as_text(drawn),
        versions=", ".join(f"{n} {metadata.version(n)}" for n in ("mujoco", "numpy", "scipy")),
        seconds=f"{seconds:.3g}",
        styles={},
        **content,
    )


def as_text(drawn: bytes | None) -> str:
    """A PNG as a page takes it; empty where there is none."""
    return "" if drawn is None else base64.b64encode(drawn).decode("ascii")


def figures(audit: Audit) -> tuple[Figure, ...]:
    """The figures of an audit."""
    if audit.found is None:
        return ()
    drawn = [errors_over_time(audit, audit.found), error_against_cost(audit.found)]
    contacts = contact_timeline(audit)
    return (*drawn, contacts) if contacts else tuple(drawn)


def errors_over_time(audit: Audit, steps: Compared) -> Figure:
    """The error at the own step and halves of it, and how well the reference is known."""
    times = audit.script.times
    finer = [s for s in steps.steps if s.integrator == audit.integrator and s.step <= audit.step]
    traces = [
        curve(times, _drawn(s.errors), colour=colour, name=f"{s.integrator} {duration(s.step)}")
        for s, colour in zip(finer[:SHOWN], COLOURS, strict=False)
    ]
    known = curve(
        times, _drawn(audit.reference.uncertainty), colour=GREY, dash="dot",
        name="the reference is known to",
    )  # fmt: skip
    return over_time(
        "Error over time",
        "The largest distance so far of any body's centre of mass from where the continuous motion "
        "has it.",
        [*traces, known],
        logarithmic("error [m]"),
    )


def error_against_cost(steps: Compared) -> Figure:
    """Every integrator and step that was run, with the Pareto front."""
    points = [
        (ns, s.at(steps.index), s) for s in steps.steps if (ns := s.ns_per_second) is not None
    ]
    best = front(points, lambda point: point[:2])
    edge: Trace = {
        **curve([ns for ns, *_ in best], positive([e for _, e, _ in best]),
                colour=GREY, width=7.0, name="Pareto front"),
        "opacity": 0.35, "hoverinfo": "skip",
    }  # fmt: skip
    traces = [edge] if best else []
    names = dict.fromkeys(s.integrator for *_, s in points)
    for name, colour in zip(names, COLOURS, strict=False):
        costs, errors, line = zip(*(p for p in points if p[2].integrator == name), strict=True)
        traces.append(
            curve(costs, positive(errors),
                  colour=colour, name=name, marks=True, hints=[duration(s.step) for s in line],
                  hint=f"{name} %{{text}}<br>error %{{y:.3g}} m<br>cost %{{x:.3g}} ns per s")
        )  # fmt: skip
    return figure(
        "Error against cost",
        "Left and low is better. The grey band is the Pareto front: no other run is both cheaper "
        "and more accurate.",
        traces,
        logarithmic("cost [ns of processor time per simulated second]"),
        logarithmic("error [m]"),
        legend=True,
    )


def contact_timeline(audit: Audit) -> Figure | None:
    """Which pairs touch when at the own step; None where none does."""
    touching = audit.touching
    if touching is None or not any(on.any() for on in touching.pairs.values()):
        return None
    pairs = list(touching.pairs)[:MOST_PAIRS]
    traces = []
    for k, name in enumerate(pairs):
        apart = np.full((len(lasting := touching.intervals(name)), 1), np.nan)
        times = np.hstack([lasting, apart]).ravel()
        traces.append(
            curve(times, np.full(times.size, float(k)), colour=COLOURS[0], width=5.0, name=name)
        )
    names = {"tickvals": list(range(len(pairs))), "ticktext": pairs}
    seconds = max(audit.until, audit.script.period)
    events = sum(1 for t in audit.reference.course.events if t <= seconds)
    lasted = float(touching.times[-1]) + audit.step
    return figure(
        "Contacts",
        f"Pairs that touch at each of the model's own steps of {duration(audit.step)}: "
        f"{touching.events / lasted:.3g} begin or cease to in a second. Along the reference "
        f"{events / seconds:.3g} contacts and limits begin or cease to act in a second.",
        traces,
        linear("time [s]"),
        linear("", automargin=True, **names),
        height=120 + 26 * len(pairs),
    )


def steps_table(audit: Audit) -> Table | None:
    """Every run; None where there is none."""
    if audit.found is None:
        return None
    index = audit.found.index
    cells = tuple(
        row(s.integrator, *(Cell(t, "number") for t in (
            duration(s.step), length(s.at(index)), _pace(s))), s.why)
        for s in audit.found.steps
    )  # fmt: skip
    heads = ("integrator", "step", "error", "processor time per simulated time", "")
    note = "Medians of interleaved turns, warm, with quartiles."
    return Table(f"Every run, up to {audit.until:.3g} s", heads, cells, note)


def trims_table(audit: Audit) -> Table | None:
    """The features whose removal was tried; None where none was."""
    if audit.trims is None or not audit.trims.each:
        return None
    tried = (*audit.trims.each, *filter(None, [audit.trims.together]))
    cells = tuple(
        row(t.name, trim_effect(t), "left out" if t is audit.trims.together else
            "the motion is the same" if t.same_bits else
            "less than a tenth of the error" if t.accepted(audit.error) else "stays")
        for t in tried
    )  # fmt: skip
    note = "On this motion only. Cost in multiples of the complete model's, with its spread."
    return Table("What can be left out", ("without", "effect", ""), cells, note)


def _pace(step: StepError) -> str:
    if step.cost is None:
        return ""
    middle, low, high = (
        f"{1e-9 * ns / step.step:.3g}"
        for ns in (step.cost.ns_per_step, step.cost.low, step.cost.high)
    )
    return f"{middle} [{low}, {high}]"


def _drawn(errors: Array) -> Array:
    return np.where(errors > 0.0, errors, np.nan)
