"""The index's section on studies that a store holds of more than one version of an engine."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plumbob.engines.study.provenance import PACKAGES, PEERS, Provenance
from plumbob.reports.view.content import Table
from plumbob.reports.view.tables import table

NO_ENGINES = ("numpy", "scipy", "numpy-quaddtype", "plotly", "jax")
ENGINES = tuple(name for name in (*PACKAGES, *PEERS) if name not in NO_ENGINES)
UNKNOWN = "unknown"


@dataclass(frozen=True)
class Versions:
    """The studies of a store, and the command that compares the last two versions."""

    table: Table
    command: str


def versions(history: Mapping[int, Provenance], folder: str) -> Versions | None:
    """The versions installed for each study of the store in `folder`, the newest first; None where
    all had the same engines. `history` has the studies by number."""
    had = {number: _engines(source) for number, source in history.items()}
    names = [n for n in ENGINES if len({each.get(n, UNKNOWN) for each in had.values()}) > 1]
    if not names:
        return None
    rows = [
        (number, history[number].date, [each.get(name, UNKNOWN) for name in names])
        for number, each in sorted(had.items(), reverse=True)
    ]
    newest = max(had)
    older = max(n for n, each in had.items() if _differ(each, had[newest], names))
    command = shlex.join(
        ["plumbob", "compare", f"{folder}#{older}", f"{folder}#{newest}", "--page", "compared.html"]
    )
    return Versions(table("versions", names=names, rows=rows), command)


def _engines(provenance: Provenance) -> Mapping[str, str]:
    return {name: provenance.versions[name] for name in ENGINES if name in provenance.versions}


def _differ(newer: Mapping[str, str], older: Mapping[str, str], names: Sequence[str]) -> bool:
    return any(newer.get(name, UNKNOWN) != older.get(name, UNKNOWN) for name in names)
