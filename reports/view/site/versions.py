"""The index's section on studies that a store holds of more than one version of an engine."""

from __future__ import annotations

import shlex
from collections.abc import Mapping

from plumbob.engines.study.provenance import PACKAGES, PEERS, Provenance
from plumbob.reports.view.site.views import View
from plumbob.reports.view.tables import table

NO_ENGINES = ("numpy", "scipy", "numpy-quaddtype", "plotly", "jax")
ENGINES = tuple(name for name in (*PACKAGES, *PEERS) if name not in NO_ENGINES)
UNKNOWN = "unknown"


def versions(history: Mapping[int, Provenance], folder: str) -> View | None:
    """The versions installed for each study of the store in `folder`, the newest first; None where
    all had the same engines. `history` has the studies by number."""
    made = dict(sorted(history.items(), reverse=True))
    names = [n for n in ENGINES if len({of.versions.get(n, UNKNOWN) for of in made.values()}) > 1]
    if not names:
        return None
    had = {number: [of.versions.get(n, UNKNOWN) for n in names] for number, of in made.items()}
    newest, *others = had
    older = next(number for number in others if had[number] != had[newest])
    command = shlex.join(
        ["plumbob", "compare", f"{folder}#{older}", f"{folder}#{newest}", "--page", "compared.html"]
    )
    rows = [(number, of.date, had[number]) for number, of in made.items()]
    return View(table=table("versions", names=names, rows=rows), command=command)
