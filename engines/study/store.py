"""Results kept in a file: each once, with a checksum, under its key; a study is a list of keys.

An SQLite file with one table. A study that is complete has a row with its list, one that is to go
on a row with its plan. What a checksum does not fit is not read: whatever has damaged a file,
nothing else has to notice it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from sqlite3 import Connection
from typing import Any, TypeVar

from plumbob.engines.study.codec import from_json, to_json
from plumbob.engines.study.results import Analysed, Study, TaskResult, assembled
from plumbob.engines.study.stability import StabilitySearch, StepPrediction
from plumbob.engines.study.store_file import (
    FILE,
    SCHEMA,
    decoding,
    reading,
    transaction,
    writing,
)

__all__ = ["FILE", "SCHEMA", "load", "save", "studies_of"]
T = TypeVar("T")
ANALYSIS = "analysis "  # of keys
STUDY, PLAN = "study", "plan"  # keys of what is no result


@dataclass(frozen=True)
class Listed:
    """A study without its results, and the keys of these, with the scene of each."""

    study: Study
    results: tuple[tuple[str, str], ...]


def save(study: Study, file: Path) -> int:
    """Add a study to `file`, made if need be; returns its number. Raises ParameterError for a file
    that is no store, or one of another version."""
    results = {
        f"{c.scene} {c.method}": TaskResult(c, pair=(c.scene, c.method)) for c in study.convergence
    }
    for scene in study.scenes:
        by_method = {m: cost for (name, m), cost in study.costs.items() if name == scene.name}
        results[f"costs of {scene.name}"] = TaskResult(
            costs=by_method, reference_step=study.reference_step, pair=(scene.name, "")
        )
    for request, result in study.extras.items():
        pair = ("", "")
        if isinstance(request, StabilitySearch | StepPrediction):
            pair = request.scene, request.method
        results[str(request)] = TaskResult(extras={request: result}, pair=pair)
    with writing(file) as store, transaction(store):
        number, _ = begun(store, "")
        keep(store, number, results)
        complete(store, number, study, results)
    return number


def begun(store: Connection, plan: str) -> tuple[int, bool]:
    """The number of the study of this plan that is to go on, or else of a new one, and whether it
    was there before."""
    with transaction(store):
        query = "select study from result where key = ? and body = ?"
        if found := store.execute(query, (PLAN, plan)).fetchone():
            return int(found[0]), True
        (last,) = store.execute("select max(study) from result").fetchone()
        number = (last or 0) + 1
        _write(store, number, PLAN, plan)
    return number, False


def forget(store: Connection, plan: str) -> None:
    """A study of this plan that is to go on does not; what is complete of it stays."""
    with transaction(store):
        number, _ = begun(store, plan)
        query = "select 1 from result where study = ? and key = ?"
        stays = store.execute(query, (number, STUDY)).fetchone()
        only = "and key = 'plan'" if stays else ""
        store.execute(f"delete from result where study = ? {only}", (number,))


def _write(store: Connection, *row: Any) -> None:
    """Write a row, in an open transaction."""
    store.execute("replace into result values (?, ?, ?, ?)", (*row, _digest(*row)))


def keep(store: Connection, number: int, results: Mapping[str, Any]) -> None:
    """Keep results of a study by their keys, in one transaction."""
    with transaction(store):
        for key, result in results.items():
            _write(store, number, key, to_json(result))


def complete(
    store: Connection,
    number: int,
    study: Study,
    results: Mapping[str, TaskResult],
    goes_on: bool = False,
) -> None:
    """Write the list of a study, its analyses with it, and take out what is not in it, the plan too
    unless the study `goes_on`."""
    results = {**results, **_by_key(study.analyses)}
    listed = tuple((key, result.pair[0]) for key, result in results.items())
    stays = [*results, STUDY, *[PLAN] * goes_on]
    with transaction(store):
        keep(store, number, _by_key(study.analyses))
        _write(store, number, STUDY, to_json(Listed(study.described(), listed)))
        query = "delete from result where study = ? and key not in (select value from json_each(?))"
        store.execute(query, (number, json.dumps(stays)))


def _by_key(analyses: Iterable[Analysed]) -> dict[str, TaskResult]:
    """Analyses as results, by their keys."""
    return {f"{ANALYSIS}{i}": TaskResult(analysis=a) for i, a in enumerate(analyses)}


def results(
    store: Connection, number: int, keys: Iterable[str], kind: type[T], scene: str = ""
) -> dict[str, T]:
    """The results of a study that are there, by their keys; one that is not as it was stored is
    what a damaged file is to SQLite."""
    found = {}
    query = "select body, digest from result where study = ? and key = ?"
    with decoding():
        for key in keys:
            if row := store.execute(query, (number, key)).fetchone():
                _intact(f"study {number}, {scene or key},", row[1], number, key, row[0])
                found[key] = from_json(row[0], kind)
    return found


def _digest(*row: Any) -> str:
    return hashlib.sha256(repr(row).encode()).hexdigest()


def _intact(what: str, digest: str, *row: Any) -> None:
    if digest != _digest(*row):
        raise ValueError(f"{what} is not as it was stored")


def _studies(store: Connection) -> dict[int, Listed]:
    """The studies that have a list, the oldest first; raises ValueError for a
    damaged one, and for results without a study."""
    query = "select study, body, digest from result where key = ? order by study"
    rows = store.execute(query, (STUDY,)).fetchall()
    for number, body, digest in rows:
        _intact(f"study {number}", digest, number, STUDY, body)
    query = "select study from result group by study having not max(key in (?, ?)) limit 1"
    for (number,) in store.execute(query, (STUDY, PLAN)).fetchall():
        raise ValueError(f"study {number} is not as it was stored")
    return {number: from_json(body, Listed) for number, body, _ in rows}


def load(file: Path, number: int | None = None) -> Study | None:
    """The study of that number, or the newest one; None where there is none. Raises ParameterError
    for a file that is no store, is damaged, or is of another version."""
    if not os.path.lexists(file):
        return None
    with reading(file) as store:
        studies = _studies(store)
        wanted = next(reversed(studies), None) if number is None else number
        return _loaded(store, wanted, studies[wanted]) if wanted in studies else None


def _loaded(store: Connection, number: int, listed: Listed) -> Study:
    found: dict[str, TaskResult] = {}
    for key, scene in listed.results:
        there = results(store, number, [key], TaskResult, scene)
        if not there:
            raise ValueError(f"study {number}, {scene or key}, is not as it was stored")
        found |= there
    return assembled(listed.study, found.values())


def studies_of(file: Path, scene: str) -> tuple[Study, ...]:
    """Each study in `file` that ran a scene, without other scenes, and of extra runs with its
    limits of the step alone, the oldest first; raises as above."""
    if not os.path.lexists(file):
        return ()
    found = []
    with reading(file) as store:
        for number, listed in _studies(store).items():
            if own := tuple(entry for entry in listed.results if entry[1] == scene):
                found.append(_loaded(store, number, replace(listed, results=own)).of_scene(scene))
    return tuple(study for study in found if any(c.measurements for c in study.convergence))
