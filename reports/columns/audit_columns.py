"""Audits as columns, from the records that `audit --json` prints."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from plumbob.reports.columns.columns import Columns, columns_of

AuditRecord = Mapping[str, Any]


def audit_columns(records: Sequence[AuditRecord]) -> Columns:
    """Returns a row for each audit."""
    return columns_of("audits", map(_row, records))


def audited_step_columns(records: Sequence[AuditRecord]) -> Columns:
    """Returns a row for each run of each audit."""
    rows = _rows(records, "steps")
    return columns_of("audited_steps", ({**r, "error": _or_infinity(r["error"])} for r in rows))


def return_columns(records: Sequence[AuditRecord]) -> Columns:
    """Returns a row for each integrator and step at which an audit has run episodes."""
    return columns_of("returns", _rows(records, "returns"))


def _rows(records: Sequence[AuditRecord], name: str) -> Iterator[dict[str, Any]]:
    """Gives the entries of a list of each audit, with the path and the name of its model."""
    for record in records:
        about = {"path": record.get("path", record["model"]), "model": record["model"]}
        yield from ({**entry, **about} for entry in record.get(name, ()))


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
