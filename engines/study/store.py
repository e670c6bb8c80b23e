"""Results kept in a file: each once, with a checksum, under its key; a study is a list of keys.

An SQLite file with one table. A study that is complete has a row with its list, one that is to go
on a row with its plan. What a checksum does not fit is not read: whatever has damaged a file,
nothing else has to notice it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from sqlite3 import Connection
from typing import Any, TypeVar

from plumbob.engines.study.codec import from_json, to_json
from plumbob.engines.study.results import Analysed, Study, TaskResult, assembled
from plumbob.engines.study.store_file import (
    FILE,
    SCHEMA,
    decoding,
    reading,
    transaction,
)

__all__ = ["FILE", "SCHEMA", "load"]
T = TypeVar("T")
ANALYSIS = "analysis "  # of keys
STUDY, PLAN = "study", "plan"  # keys of what is no result


@dataclass(frozen=True)
class Listed:
    """A study without its results, and the keys of these, with the scene of each."""

    study: Study
    results: tuple[tuple[str, str], ...]


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
    listed = tuple((key, result.scene) for key, result in results.items())
    stays = [*results, STUDY, *[PLAN] * goes_on]
    with transaction(store):
        keep(store, number, _by_key(study.analyses))
        _write(store, number, STUDY, to_json(Listed(study.described(), listed)))
        query = (
            "delete from result where study = ? and key not in (select value from json_each(?))"
        )
        store.execute(query, (number, json.dumps(stays)))


def _by_key(analyses: Iterable[Analysed]) -> dict[str, TaskResult]:
    """Analyses as results, by their keys."""
    return {f"{ANALYSIS}{i}": TaskResult(a) for i, a in enumerate(analyses)}


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


def load(file: Path, number: int | None = None, scenes: Collection[str] = ()) -> Study | None:
    """The study of that number, or the newest one, of all or of these `scenes` alone, some of which
    it has; None where there is none. Raises ParameterError for a file that is no store, is damaged,
    or is of another version."""
    if not os.path.lexists(file):
        return None
    with reading(file) as store:
        for n, listed in reversed(_studies(store).items()):
            there = tuple(e for e in listed.results if not scenes or e[1] in scenes)
            if number in (None, n) and (there or not scenes):
                return _loaded(store, n, replace(listed, results=there))
    return None


def in_any_study(file: Path, keys: Collection[str]) -> dict[str, TaskResult]:
    """The results that a study of a store, the newest, has under these keys, but for what was given
    up; raises as above."""
    found: dict[str, TaskResult] = {}
    with reading(file) as store:
        rows = store.execute("select distinct study from result order by study desc").fetchall()
        for (number,) in rows:
            there = results(
                store, number, [key for key in keys if key not in found], TaskResult
            )
            found |= {key: result for key, result in there.items() if not result.lost}
    return found


def _loaded(store: Connection, number: int, listed: Listed) -> Study:
    found: dict[str, TaskResult] = {}
    for key, scene in listed.results:
        there = results(store, number, [key], TaskResult, scene)
        if not there:
            raise ValueError(f"study {number}, {scene or key}, is not as it was stored")
        found |= there
    return assembled(listed.study, found.values())
