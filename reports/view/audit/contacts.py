"""Numbers that the template of a contact audit needs beside the audit itself."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from plumbob.engines.audit.contacts import HEADINGS, PUSH, ContactAudit, ContactRun
from plumbob.reports.advice.audit_advice import error_trend


def contact_numbers(audit: ContactAudit) -> dict[str, Any]:
    """Returns the numbers of the template: `kinds`, results on the model's own contacts and on the
    pasted contacts; `tends`, the known distances [m] that the runs are compared with, in ascending
    order; `push`; `headings` [°]; and `degree`, the degrees in a radian."""
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
    """Returns the results on contacts of one kind, for the template. `runs` goes from the coarsest
    step to the finest; its first run has the model's own step.

    The values of the first run are: `errors` of the distances [m] by heading; `worst`, the index of
    the heading with the largest error (-1 if no error is known); `stuck`, the headings [°] at which
    the body does not stop; `per_cents`, the known errors [%], and `per_cent`, the largest of them;
    `predicted`, the error that theory predicts at the worst heading [%] (NaN if a load reaches 0);
    and `turn`, the turn of the body [rad], if it turns and comes to rest.

    The values of all runs are: `halving`, the largest error [m] at each step, and `trend`, how
    halving the step helps."""
    if not runs:
        return {"name": name, "runs": runs, "worst": -1, "halving": ()}
    run = runs[0]
    errors = audit.errors(run)
    worst = -1 if np.isnan(errors).all() else int(np.nanargmax(np.abs(errors)))
    relative = 100 * errors / audit.distances
    per_cents = relative[~np.isnan(relative)]
    predicted = audit.predicted(run)
    predicted_per_cent = None
    if predicted is not None and audit.exact:
        predicted_per_cent = 100 * predicted[worst] / audit.exact
    halving = [audit.error(finer) for finer in runs]
    if runs is audit.pasted and audit.exact is None:
        halving = halving[:-1]  # the finest run is the reference, so it has no error
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
        "predicted": predicted_per_cent,
        "turn": run.turning.turn if run.turning and run.turning.rests else None,
        "halving": halving if known else (),
        "trend": error_trend(halving) if known else None,
    }
