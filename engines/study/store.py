"""Results stored in a file: each once, with a checksum, under its key; a study is a list of keys.

The file is an SQLite file with one table. A complete study has a row with its list of keys; a study
that is to be resumed has a row with its plan. A row whose checksum does not fit is not read, so
that no other code has to notice damage."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from sqlite3 import Connection
from typing import Any, Generic, TypeVar

from plumbob.engines.study.codec import from_json, to_json
from plumbob.engines.study.results import Analysed, Study, TaskResult, assembled_study, coherent
from plumbob.engines.study.shard import MeasuredShard, damaged_shard
from plumbob.engines.study.store_file import (
    FILE,
    SCHEMA,
    decoding,
    reading_connection,
    transaction,
)

__all__ = ["FILE", "SCHEMA", "load"]
Result = TypeVar("Result")
Whole = TypeVar("Whole")
ANALYSIS = "analysis "  # beginning of the keys of analyses
STUDY, PLAN = "study", "plan"  # keys of the rows with a study's list and plan
SHARD_KEY = "shard "  # beginning of the keys of measured shards
# A damaged row may hold a text, or the largest integer, as the number of its study.
NUMBERED = "typeof(study) = 'integer' and study between 1 and 1000000000000"


@dataclass(frozen=True)
class Listed:
    """A study without its results, and the key and the scene of each result."""

    study: Study
    results: tuple[tuple[str, str], ...]


def study_number(store: Connection, plan: str) -> tuple[int, bool]:
    """Returns the number of the study with this plan, and whether the store had it before. If it
    did not, the plan is stored with the next number."""
    with transaction(store):
        query = f"select study from result where key = ? and body = ? and {NUMBERED}"
        if found := store.execute(query, (PLAN, plan)).fetchone():
            return int(found[0]), True
        (last,) = store.execute(f"select max(study) from result where {NUMBERED}").fetchone()
        number = (last or 0) + 1
        _write(store, number, PLAN, plan)
    return number, False


def forget(store: Connection, plan: str) -> None:
    """Removes the plan of a study that was to be resumed. If the study was complete before, its
    results stay."""
    with transaction(store):
        number, _ = study_number(store, plan)
        query = "select 1 from result where study = ? and key = ?"
        stays = store.execute(query, (number, STUDY)).fetchone()
        only = "and key = 'plan'" if stays else ""
        store.execute(f"delete from result where study = ? {only}", (number,))


def _write(store: Connection, *row: Any) -> None:
    """Writes a row with its checksum, in an open transaction."""
    store.execute("replace into result values (?, ?, ?, ?)", (*row, _digest(*row)))


def keep(store: Connection, number: int, results: Mapping[str, Any]) -> None:
    """Stores results of a study by their keys, in one transaction."""
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
    """Writes the list of a study and its analyses, and deletes rows that are not in the list. The
    plan is deleted too, unless the study `goes_on`."""
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
    """Analyses as task results, by their keys."""
    return {f"{ANALYSIS}{i}": TaskResult(a) for i, a in enumerate(analyses)}


def stored_results(
    store: Connection, number: int, keys: Iterable[str], kind: type[Result]
) -> dict[str, Result]:
    """{key: result} of a study, for those of the `keys` that are stored and undamaged."""
    found = {}
    with decoding():
        for key in keys:
            body = _intact(store, number, key)
            if body is not None:
                found[key] = from_json(body, kind)
    return found


def keep_shard(store: Connection, number: int, shard: MeasuredShard) -> None:
    """Stores that a shard of a study or of a sweep is measured to its end."""
    keep(store, number, {f"{SHARD_KEY}{shard.shard}": shard})


def newest_shards(store: Connection) -> tuple[int, list[MeasuredShard]]:
    """Returns the number of the newest study or sweep that has shards measured to their ends, and
    these shards; 0 and no shards if there is none."""
    query = f"select study, key from result where key glob 'shard *' and {NUMBERED}"
    rows: list[tuple[int, str]] = store.execute(query).fetchall()
    newest = max((number for number, _ in rows), default=0)
    keys = sorted(key for number, key in rows if number == newest)
    return newest, list(stored_results(store, newest, keys, MeasuredShard).values())


@dataclass(frozen=True)
class StoredShard(Generic[Whole, Result]):
    """A stored shard of a study or of a sweep."""

    folder: Path
    measured: MeasuredShard
    whole: Whole  # what all shards are parts of
    results: dict[str, Result]  # by key


def stored_shards(
    file: Path, whole_key: str, whole_kind: type[Whole], result_kind: type[Result]
) -> list[StoredShard[Whole, Result]]:
    """Returns the shards of the newest study or sweep in a store, which has the whole under
    `whole_key`. Raises ParameterError if a shard is damaged."""
    shards = []
    with reading_connection(file) as store:
        number, measured_shards = newest_shards(store)
        whole = stored_results(store, number, [whole_key], whole_kind).get(whole_key)
        for measured in measured_shards:
            results = stored_results(store, number, measured.keys, result_kind)
            if whole is None or len(results) < len(measured.keys):
                raise damaged_shard(file.parent, measured.shard)
            shards.append(StoredShard(file.parent, measured, whole, results))
    return shards


def has_shards(file: Path) -> bool:
    """Returns whether a store exists and holds shards that are measured to their ends. Raises
    ParameterError if it cannot be read."""
    if not os.path.lexists(file):
        return False
    with reading_connection(file) as store:
        return bool(newest_shards(store)[1])


def numbers_with(store: Connection, key: str) -> list[int]:
    """The numbers under which a row with this key is stored, the oldest first."""
    query = f"select study from result where key = ? and {NUMBERED} order by study"
    return [number for (number,) in store.execute(query, (key,)).fetchall()]


def _digest(*row: Any) -> str:
    """The checksum of a row: number of the study, key, text."""
    return hashlib.sha256(repr(row).encode()).hexdigest()


def _intact(store: Connection, number: int, key: str) -> str | None:
    """The text stored under a key of a study; None if there is none, or if it is damaged."""
    query = "select body, digest from result where study = ? and key = ?"
    row = store.execute(query, (number, key)).fetchone()
    if row is None or not isinstance(row[0], str) or row[1] != _digest(number, key, row[0]):
        return None
    return row[0]


def _numbers(store: Connection) -> list[int]:
    """The numbers of the complete studies, the newest first. A study with neither a list nor a plan
    counts: it was complete, and has lost its list."""
    query = f"""select study from result where {NUMBERED} group by study
        having max(key = ?) or not max(key = ?) order by study desc"""
    return [number for (number,) in store.execute(query, (STUDY, PLAN)).fetchall()]


def _listed(store: Connection, number: int) -> Listed:
    """A complete study's list of results; raises ValueError if the list is damaged."""
    body = _intact(store, number, STUDY)
    if body is None:
        raise _lost(number)
    return from_json(body, Listed)


def _lost(number: int, what: str = "") -> ValueError:
    """The error for a damaged study, or for `what` of it; its text says what to do."""
    return ValueError(
        f"study {number}{what} is not as it was stored: measure again, or name another study of "
        "the file by its number"
    )


def damages(store: Connection) -> Iterator[str]:
    """Yields for each damaged study why it cannot be read any more."""
    for number in _numbers(store):
        try:
            listed = _listed(store, number)
            keys = [key for key, _ in listed.results]
            there = {key for key in keys if _intact(store, number, key) is not None}
            _all_there(listed, number, there)
        except ValueError as why:
            yield str(why)


def _all_there(listed: Listed, number: int, there: Collection[str]) -> None:
    """Raises ValueError if a result of a study is not among the keys that are `there`."""
    for key, scene in listed.results:
        if key not in there:
            raise _lost(number, f", {scene or key},")


def load(file: Path, number: int | None = None, scenes: Collection[str] = ()) -> Study | None:
    """The study with this number, or the newest study; None if there is none. If `scenes` are
    given, only their results are loaded, and a study without any of them is passed over. Raises
    ParameterError if the file is no store, is of another version, or if that study is damaged;
    other studies are not read."""
    if not os.path.lexists(file):
        return None
    with reading_connection(file) as store:
        for n in _numbers(store):
            if number not in (None, n):
                continue
            listed = _listed(store, n)
            there = tuple(e for e in listed.results if not scenes or e[1] in scenes)
            if there or not scenes:
                return _loaded(store, n, replace(listed, results=there))
    return None


def in_any_study(file: Path, keys: Collection[str]) -> dict[str, TaskResult]:
    """{key: result} of the results that any study of a store has under these keys, the newest
    first, without those that were given up. Raises ParameterError as `load` does."""
    found: dict[str, TaskResult] = {}
    with reading_connection(file) as store:
        query = f"select distinct study from result where {NUMBERED} order by study desc"
        rows = store.execute(query).fetchall()
        for (number,) in rows:
            there = stored_results(
                store, number, [key for key in keys if key not in found], TaskResult
            )
            found |= {key: result for key, result in there.items() if not result.lost}
    return found


def _loaded(store: Connection, number: int, listed: Listed) -> Study:
    """The study with its listed results; raises ValueError or sqlite3.DatabaseError if damaged."""
    found = stored_results(store, number, (key for key, _ in listed.results), TaskResult)
    _all_there(listed, number, found)
    with decoding():
        subjects = {result.subject for result in found.values()}
        scenes = tuple((key, found[key].scene) for key, _ in listed.results)
        if len(subjects) < len(found) or scenes != listed.results:
            raise ValueError("a result stands under the key of another")
        return coherent(assembled_study(listed.study, found.values()))
