"""Results kept in a file: each once, with a checksum, under its key; a study is a list of keys.

An SQLite file with two tables. A study that is not complete has a row with its plan, and no list
yet. What a checksum does not fit is not read: whatever has damaged a file, nothing else has to
notice it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
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
Listed = list[tuple[str, str]]  # keys of a study's results, with the scene of each


def save(study: Study, file: Path) -> int:
    """Add a study to `file`, made if need be; returns its number. Raises ParameterError for a file
    that is no store, or one of another version."""
    results = {
        f"{c.scene} {c.method}": TaskResult(
            c,
            cost=study.costs.get((c.scene, c.method)),
            reference_step=study.reference_step,
            pair=(c.scene, c.method),
        )
        for c in study.convergence
    }
    for request, result in study.extras.items():
        pair = ("", "")
        if isinstance(request, StabilitySearch | StepPrediction):
            pair = request.scene, request.method
        results[str(request)] = TaskResult(extras={request: result}, pair=pair)
    with writing(file) as store, transaction(store):
        number, _ = begun(store, None)
        keep(store, number, results)
        complete(store, number, None, study, results)
    return number


def begun(store: Connection, plan: str | None) -> tuple[int, bool]:
    """The number of the study of this plan that is not complete, or else of a new one, and whether
    it was there before."""
    with transaction(store):
        found = store.execute("select id from study where plan = ?", (plan,)).fetchone()
        if found is not None:
            return int(found[0]), True
        number = store.execute("insert into study (digest) values ('')").lastrowid
        assert number is not None
        _write(store, number, plan, None, None)
    return number, False


def forget(store: Connection, plan: str) -> None:
    """A study of this plan that is not complete is never gone on with."""
    with transaction(store):
        query = "select id, body, results from study where plan = ?"
        for number, body, listed in store.execute(query, (plan,)).fetchall():
            if body is None:
                store.execute("delete from result where study = ?", (number,))
                store.execute("delete from study where id = ?", (number,))
            else:
                _write(store, number, None, body, listed)


def _write(store: Connection, *row: Any) -> None:
    """Write the row of a study, in an open transaction."""
    store.execute("replace into study values (?, ?, ?, ?, ?)", (*row, _digest(*row)))


def keep(store: Connection, number: int, results: Mapping[str, Any]) -> None:
    """Keep results of a study by their keys, in one transaction."""
    with transaction(store):
        for key, result in results.items():
            row = (number, key, to_json(result))
            store.execute("replace into result values (?, ?, ?, ?)", (*row, _digest(*row)))


def complete(
    store: Connection,
    number: int,
    plan: str | None,
    study: Study,
    results: Mapping[str, TaskResult],
) -> None:
    """Write the list of a study, its analyses with it, and take out what is not in it; with its
    `plan` where the study is to go on."""
    results = {**results, **_by_key(study.analyses)}
    listed = json.dumps([(key, result.pair[0]) for key, result in results.items()])
    with transaction(store):
        keep(store, number, _by_key(study.analyses))
        _write(store, number, plan, to_json(study.described()), listed)
        query = "delete from result where study = ? and key not in (select value from json_each(?))"
        store.execute(query, (number, json.dumps(list(results))))


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


def _studies(store: Connection) -> dict[int, tuple[str, Listed]]:
    """The studies that have a list, the oldest first, as JSON; raises ValueError for a damaged one,
    and for results without a study."""
    query = "select id, plan, body, results, digest from study order by id"
    rows = store.execute(query).fetchall()
    for *row, digest in rows:
        _intact(f"study {row[0]}", digest, *row)
    query = "select study from result where study not in (select id from study) limit 1"
    for (number,) in store.execute(query).fetchall():
        raise ValueError(f"study {number} is not as it was stored")
    return {
        number: (body, json.loads(listed))
        for number, _, body, listed, _ in rows
        if body is not None
    }


def load(file: Path, number: int | None = None) -> Study | None:
    """The study of that number, or the newest one; None where there is none. Raises ParameterError
    for a file that is no store, is damaged, or is of another version."""
    if not os.path.lexists(file):
        return None
    with reading(file) as store:
        studies = _studies(store)
        wanted = next(reversed(studies), None) if number is None else number
        return _loaded(store, wanted, *studies[wanted]) if wanted in studies else None


def _loaded(store: Connection, number: int, body: str, listed: Listed) -> Study:
    found: dict[str, TaskResult] = {}
    for key, scene in listed:
        there = results(store, number, [key], TaskResult, scene)
        if not there:
            raise ValueError(f"study {number}, {scene or key}, is not as it was stored")
        found |= there
    return assembled(from_json(body, Study), found.values())


def studies_of(file: Path, scene: str) -> tuple[Study, ...]:
    """Each study in `file` that ran a scene, without other scenes, and of extra runs with its
    limits of the step alone, the oldest first; raises as above."""
    if not os.path.lexists(file):
        return ()
    found = []
    with reading(file) as store:
        for number, (body, listed) in _studies(store).items():
            if own := [entry for entry in listed if entry[1] == scene]:
                found.append(_loaded(store, number, body, own).of_scene(scene))
    return tuple(study for study in found if any(c.measurements for c in study.convergence))
