"""Stored results from Python: the studies, sweeps and audits of a folder as columns."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store
from plumbob.engines.study.results import Study
from plumbob.engines.sweep import store as sweep_store
from plumbob.models.border import must_be, regular_file
from plumbob.reports.columns.audit_columns import (
    audit_columns,
    audited_step_columns,
    return_columns,
)
from plumbob.reports.columns.columns import Columns
from plumbob.reports.columns.study_columns import StudyColumns
from plumbob.reports.columns.sweep_columns import point_columns

LARGEST_AUDIT_FILE = 100_000_000  # [bytes]
HOLDS_RESULTS = (
    "a folder of results, a file of stored studies, or a file that `audit --json` wrote"
)


class StoredResults(StudyColumns):
    """The stored results of a folder, as tables of columns (`plumbob list columns` lists them).

    Of the newest study, or the one that was asked for: `pairs`, `runs`, `errors`, `budgets`,
    `parameters`, `recommendations`, `trims` and `derivatives`. `sweeps` has a table of points for
    each sweep. `audits` has a row for each audit that was written with `--out` or `--json`, and
    `audited_steps` a row for each of their runs, and `returns` one for each mean return of
    episodes.

    A table is computed when it is first asked for. `table["error"]` is a numpy array;
    `table.to_pandas()`, `table.to_csv()` and `table.to_latex()` write tables elsewhere."""

    def __init__(
        self, study: Study | None, sweeps: Path | None, audits: tuple[Path, ...]
    ) -> None:
        super().__init__(study)
        self._sweep_file = sweeps
        self._audit_files = audits

    @cached_property
    def sweeps(self) -> tuple[Columns, ...]:
        """A table of points for each sweep, the oldest first. Version 0.4.0 stored no request with
        a sweep: its sweeps are left out until the same command is given again."""
        if self._sweep_file is None:
            return ()
        return tuple(map(point_columns, sweep_store.stored_sweeps(self._sweep_file)))

    @cached_property
    def _audit_records(self) -> list[Mapping[str, Any]]:
        """The records of the audits."""
        return [record for file in self._audit_files for record in _read_audits(file)]

    @cached_property
    def audits(self) -> Columns:
        """A row for each audit."""
        return audit_columns(self._audit_records)

    @cached_property
    def audited_steps(self) -> Columns:
        """A row for each run of each audit."""
        return audited_step_columns(self._audit_records)

    @cached_property
    def returns(self) -> Columns:
        """A row for each integrator and step at which an audit has run episodes."""
        return return_columns(self._audit_records)


def load_results(path: str | Path, study: int | None = None) -> StoredResults:
    """Returns the results that are stored in a folder, such as "plumbob-out", in a file of studies,
    or in a file that `plumbob audit --json` printed: of the newest complete study, or of the study
    with this number. Raises ParameterError if there are none, or a file is damaged.

    Example:

        import plumbob
        data = plumbob.load("plumbob-out")
        frame = data.errors.to_pandas()
    """
    place = Path(path)
    if place.suffix == ".json":
        return StoredResults(None, None, (place,))
    folder = place.is_dir()
    stored = store.load(place / store.FILE if folder else place, study)
    if study is not None and stored is None:
        raise ParameterError("study", study, f"the number of a complete study in {place}")
    sweeps = place / sweep_store.FILE
    audits = tuple(sorted(place.glob("audit-*.json"))) if folder else ()
    has_sweeps = folder and sweeps.is_file()
    if stored is None and not has_sweeps and not audits:
        raise ParameterError("path", str(place), HOLDS_RESULTS)
    return StoredResults(stored, sweeps if has_sweeps else None, audits)


def _read_audits(file: Path) -> list[Mapping[str, Any]]:
    """Returns the audits in a file that `audit --json` or `audit --out` wrote. Raises
    ParameterError."""
    regular_file("path", file, LARGEST_AUDIT_FILE)
    with must_be("a file that `plumbob audit --json` printed", "path", str(file)):
        content = json.loads(file.read_text("utf-8"))
        audits: list[Mapping[str, Any]] = content if isinstance(content, list) else [content]
        # Audits that are no audits fail here, and not when a table is asked for.
        audit_columns(audits)
        audited_step_columns(audits)
    return audits
