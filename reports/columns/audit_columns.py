"""Audits as columns, from the records that `audit --json` prints."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from plumbob.reports.columns.columns import Columns, columns_of

AuditRecord = Mapping[str, Any]


def audit_columns(records: Sequence[AuditRecord]) -> Columns:
    """Returns a row for each audit."""
    return columns_of("audits", map(_row, records))


def audited_step_columns(records: Sequence[AuditRecord]) -> Columns:
    """Returns a row for each run of each audit."""
    rows = []
    for record in records:
        about = {"path": record.get("path", record["model"]), "model": record["model"]}
        rows += [
            {**run, **about, "error": _or_infinity(run["error"])}
            for run in record.get("steps", ())
        ]
    return columns_of("audited_steps", rows)


def _row(record: AuditRecord) -> dict[str, Any]:
    """Returns the row of an audit. A motion that is certified and an error without a value mean
    that the run diverged: JSON has no infinity."""
    certified = bool(record.get("certified_until"))
    order = record.get("order")
    limits = record.get("stability") or [{}]
    return {
        **record,
        "path": record.get("path", record["model"]),
        "error": _or_infinity(record.get("error")) if certified else record.get("error"),
        "order": order and order["slope"],
        "largest_step": limits[0].get("largest_step"),
        "mujoco": record.get("versions", {}).get("mujoco"),
    }


def _or_infinity(error: float | None) -> float:
    """Returns an error; infinity if it has no value."""
    return math.inf if error is None else error
