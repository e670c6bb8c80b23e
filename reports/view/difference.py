"""Recorded motions held against a model: terminal lines, plain data, and a page with the band and
both motions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.engines.study.provenance import provenance
from plumbob.reports.judge.differences import EXPLAINED, difference_verdict, is_own_law
from plumbob.reports.records.plain_data import FOR_JSON, plain
from plumbob.reports.view.content import Figure
from plumbob.reports.view.page import fill_page, write_file
from plumbob.reports.view.tables import figures, table_or_none, terminal_lines

if TYPE_CHECKING:  # records that need the theory of the band
    from plumbob.engines.difference.difference import ComparedMotions, MotionDifference
    from plumbob.engines.difference.step_check import CheckedSteps, StepFinding

DIFFERENCE_PAGE = "difference.html"
PACKAGES_USED = ("mujoco", "numpy", "scipy")
SHOWN_COORDINATES = 4  # coordinates whose motions the page shows: those that differ most
LINES = 5  # findings of a recording that the terminal shows


def difference_lines(compared: ComparedMotions) -> list[str]:
    """Returns the answer as the lines of a terminal."""
    return terminal_lines("difference", **_words(compared))


def _words(compared: ComparedMotions) -> dict[str, Any]:
    """Returns the values that the templates of the terminal and of the page take."""
    return {
        "compared": compared,
        "model": compared.model,
        "verdict": difference_verdict(compared),
        "difference": compared.difference,
        "motions": list(zip(compared.recordings, compared.steps, strict=True)),
        "is_own": lambda steps: is_own_law(compared, steps.law),
        "most": LINES,
    }


def difference_record(compared: ComparedMotions) -> dict[str, Any]:
    """Returns the answer as the JSON object that `--json` prints."""
    versions = provenance("").versions
    verdict = difference_verdict(compared)
    values = {
        "model": compared.model.name,
        "integrator": compared.model.integrator,
        "step": compared.model.step,
        "verdict": verdict,
        "explained": verdict in EXPLAINED,
        "recordings": [
            {
                "recording": recording.name,
                "samples": len(recording.times),
                "resolution": recording.resolution.words,
                "warm_starts": recording.warm_starts is not None,
                **_steps_record(steps),
            }
            for recording, steps in zip(compared.recordings, compared.steps, strict=True)
        ],
        "difference": _difference_record(compared.difference),
        "versions": {name: versions[name] for name in PACKAGES_USED},
    }
    return dict(plain(values, FOR_JSON))


def _steps_record(steps: CheckedSteps) -> dict[str, Any]:
    """Returns the JSON data of a recording's checked steps."""
    return {
        "law": steps.law,
        "checked": steps.checked,
        "largest_left": steps.largest_left,
        "largest_allowed": steps.largest_allowed,
        "allowed_by_rounding": steps.rounding,
        "allowed_by_solver": steps.solver,
        "findings": [_finding_record(finding) for finding in steps.findings],
        "further_findings": steps.further,
        "common_cause": None
        if steps.common is None
        else {
            "kind": steps.common.kind,
            "part": steps.common.part,
            "factor": steps.common.factor,
        },
    }


def _finding_record(finding: StepFinding) -> dict[str, Any]:
    """Returns the JSON data of a finding: a recorded step that the model does not take."""
    names = ("begin", "end", "place", "left", "allowed", "unit", "excess")
    return {
        "row": finding.interval,
        **{name: getattr(finding, name) for name in names},
        "cause": finding.cause.kind,
        "part": finding.cause.part,
        "factor": finding.cause.factor,
    }


def _difference_record(difference: MotionDifference | None) -> dict[str, Any] | None:
    """Returns the JSON data of the difference of two recordings; None if there is one recording."""
    if difference is None:
        return None
    return {
        **{name: value for name, value in vars(difference).items() if name != "solver"},
        "solver_bounds": difference.solver,
        "largest_use": difference.largest_use,
    }


def write_difference_page(compared: ComparedMotions, folder: Path, command: str) -> Path:
    """Writes the page of a comparison into `folder` and returns its path. `command` repeats the
    comparison. Raises OSError if the folder cannot be written."""
    words = _words(compared)
    page = fill_page(
        "difference.html.jinja",
        **words,
        lines=terminal_lines("difference", **words),
        figures=_figures(compared),
        findings=table_or_none("step_findings", motions=words["motions"]),
        made=provenance(command),
    )
    return write_file(page, folder, DIFFERENCE_PAGE)


def _figures(compared: ComparedMotions) -> tuple[Figure, ...]:
    """Returns the figures of the page: the difference beside the band, and the coordinates that
    differ most in both motions."""
    first = compared.recordings[0]
    names = compared.model.names["position"]
    states = [recording.states for recording in compared.recordings]
    count = min(len(first.states), len(states[-1]))
    spans = np.abs(states[-1][:count] - states[0][:count]).max(axis=0)
    if len(states) == 1:
        spans = np.ptp(first.states, axis=0)
    places = _places_of_positions(compared)
    order = sorted(range(len(names)), key=lambda number: -spans[places[number]])
    return figures(
        "difference",
        difference=compared.difference,
        shown=[
            (
                names[number],
                [(motion, motion.states[:, places[number]]) for motion in compared.recordings],
            )
            for number in order[:SHOWN_COORDINATES]
        ],
    )


def _places_of_positions(compared: ComparedMotions) -> list[int]:
    """Returns the place in a state of the coordinate of each degree of freedom; of a rotation that
    of its quaternion's numbers in the same order, without the scalar."""
    places: list[int] = []
    for joint in compared.model.layout.joints:
        moved = list(range(joint.position, joint.position + joint.size))
        if joint.size > 1:
            moved[-3:] = [place + 1 for place in moved[-3:]]
        places += moved
    return places
