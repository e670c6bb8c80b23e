"""The figures of a contact audit's answer that its template needs beside the audit itself."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from plumbob.engines.audit.contacts import HEADINGS, PUSH, ContactAudit, ContactRun
from plumbob.reports.view.audit.motion import mean_ratio


def answer_of(audit: ContactAudit) -> dict[str, Any]:
    """A contact audit, and what follows from it: runs on the model's own contacts and on the pasted
    ones, and the distances [m] to compare with, from the least on, none where none is known."""
    known = audit.distances[~np.isnan(audit.distances)]
    return {
        "kinds": (
            _kind("your contacts", audit, audit.own),
            _kind("pasted contacts", audit, audit.pasted),
        ),
        "tends": sorted(known.tolist()),
        "push": PUSH,
        "headings": np.degrees(HEADINGS).tolist(),
        "degree": math.degrees(1.0),
    }


def _kind(name: str, audit: ContactAudit, runs: tuple[ContactRun, ...]) -> dict[str, Any]:
    """Runs of the body on contacts of one kind, coarse to fine, and that at the own step: errors of
    its distances [m] by heading and, where they are known, [%]; the heading with the largest (-1
    where none is known), and what theory predicts of that [%] (not a number where a load gets to
    0); headings [°] at which the body does not stop; its turn [rad] where it turns too. Last the
    largest error [m] at each step that is compared, and their mean ratio."""
    if not runs:
        return {"name": name, "runs": runs, "worst": -1, "halving": ()}
    run = runs[0]
    errors = audit.errors(runs[0])
    worst = -1 if np.isnan(errors).all() else int(np.nanargmax(np.abs(errors)))
    relative = 100 * errors / audit.distances
    per_cents = relative[~np.isnan(relative)]
    predicted = audit.predicted(run)
    halving = [audit.error(each) for each in runs]
    if runs is audit.pasted and audit.exact is None:
        halving = halving[:-1]  # the finest is what is compared with
    known = len(halving) > 1 and np.isfinite(halving).all() and halving[0]
    return {
        "name": name,
        "runs": runs,
        "run": run,
        "errors": errors,
        "worst": worst,
        "stuck": np.degrees(HEADINGS)[np.isinf(errors)].tolist(),
        "per_cents": per_cents,
        "per_cent": max(per_cents.tolist(), key=abs, default=math.nan),
        "predicted": 100 * predicted[worst] / audit.exact
        if predicted is not None and audit.exact
        else None,
        "turn": run.turning.turn if run.turning and run.turning.rests else None,
        "halving": halving if known else (),
        "ratio": mean_ratio(halving) if known else None,
    }
