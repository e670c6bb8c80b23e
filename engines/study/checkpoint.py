"""Checkpoints of an interrupted study: each result is stored at once, under a hash of its
inputs."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from functools import cache
from pathlib import Path
from sqlite3 import Connection, connect
from typing import Any

from plumbob.engines.study import store
from plumbob.engines.study.codec import unstructured
from plumbob.engines.study.provenance import result_versions
from plumbob.engines.study.results import Study, TaskResult
from plumbob.engines.study.shard import MeasuredShard, Shard
from plumbob.engines.study.store_file import create, writing

SOURCES = ("analytic", "models", "engines")  # folders whose files change results
WHOLE = "whole"  # key of the list of results of the study to which a shard belongs
Note = Callable[[str], None]


class Checkpoint:
    """The stored results of a study that is being measured."""

    def __init__(self, opened: Connection, fresh: bool, note: Note) -> None:
        self._store, self._fresh, self._note = opened, fresh, note
        self.number = 0
        self.given_up: tuple[str, ...] = ()  # tasks that were given up, each with its reason

    def begin(self, plan: str, keys: Sequence[str]) -> bool:
        """Begins or resumes the study of this plan, which consists of the results with these keys
        and of costs that follow from them. Returns whether the study was begun before."""
        if self._fresh:
            store.forget(self._store, plan)
        self.number, before = store.study_number(self._store, plan)
        if count := len(self.there(keys)):
            self._note(f"goes on: {count} of {len(keys)} results are there")
        return before

    def there(self, keys: Sequence[str]) -> dict[str, TaskResult]:
        """The results with these keys that are stored, without those that were given up."""
        found = store.stored_results(self._store, self.number, keys, TaskResult)
        return {key: result for key, result in found.items() if not result.lost}

    def keep(self, results: Mapping[str, TaskResult]) -> None:
        """Stores results by their keys, in one transaction."""
        store.keep(self._store, self.number, results)

    def complete(self, study: Study, results: Mapping[str, TaskResult]) -> None:
        """Completes the study: it has these results and no others. If some were given up, the same
        command tries them again."""
        self.given_up = _given_up(results)
        store.complete(self._store, self.number, study, results, bool(self.given_up))

    def complete_shard(
        self, shard: MeasuredShard, whole: store.Listed, results: Mapping[str, TaskResult]
    ) -> None:
        """Stores that a shard is measured to its end with these results, and the list of the whole
        study. If some results were given up, the same command tries them again."""
        self.given_up = _given_up(results)
        store.keep(self._store, self.number, {WHOLE: whole})
        store.keep_shard(self._store, self.number, shard)


class SharedResults(Checkpoint):
    """Results that belong to no study. A result is found by its key, also in a file of `studies`;
    no study is begun or completed."""

    def __init__(self, opened: Connection, studies: Path, note: Note) -> None:
        super().__init__(opened, False, note)
        self._studies = studies
        self.number, _ = store.study_number(opened, "")

    def begin(self, plan: str, keys: Sequence[str]) -> bool:
        """Does nothing: shared results belong to no study. Returns False."""
        return False

    def there(self, keys: Sequence[str]) -> dict[str, TaskResult]:
        """The results with these keys that are stored here or in a study, without those that were
        given up."""
        found = super().there(keys)
        missing = [key for key in keys if key not in found]
        if missing and os.path.lexists(self._studies):
            found |= store.in_any_study(self._studies, missing)
        return found

    def complete(self, study: Study, results: Mapping[str, TaskResult]) -> None:
        """Does nothing: shared results belong to no study."""


def _given_up(results: Mapping[str, TaskResult]) -> tuple[str, ...]:
    """The tasks that were given up, each with its reason."""
    return tuple(f"{result.label}: {result.lost}" for result in results.values() if result.lost)


def measured_shard(shard: Shard, plan: str, keys: Iterable[str]) -> MeasuredShard:
    """The record of a shard that this process has measured, with the keys of its results."""
    return MeasuredShard(shard, plan, key_of(), result_versions(), tuple(keys))


@contextmanager
def shared_results(file: Path | None, studies: Path, note: Note) -> Iterator[SharedResults]:
    """The shared results in `file`, which is made if there is none, or in memory if `file` is None.
    Raises ParameterError as `measured_into` does."""
    with _opened(file, note) as opened:
        yield SharedResults(opened, studies, note)


@contextmanager
def measured_into(
    file: Path | None, fresh: bool = False, note: Note = lambda _: None
) -> Iterator[Checkpoint]:
    """The checkpoint in the store `file`, which is made if there is none, or in memory if `file` is
    None. If `fresh`, a study that is not complete is not resumed but begun anew. `note` is called
    with lines for the user, such as which older studies are damaged. Raises ParameterError if the
    file is no store or cannot be written."""
    with _opened(file, note) as opened:
        for why in store.damages(opened):
            note(f"{file}: {why}")
        yield Checkpoint(opened, fresh, note)


@contextmanager
def _opened(file: Path | None, note: Note) -> Iterator[Connection]:
    """Yields a connection to the store in a file, which is locked so that no other process adds
    measurements to it; or to a store in memory if `file` is None."""
    if file is None:
        with closing(connect(":memory:", isolation_level=None)) as opened:
            create(opened)
            yield opened
        return
    with _alone(file.parent, note), writing(file) as opened:
        yield opened


@contextmanager
def _alone(folder: Path, note: Note) -> Iterator[None]:
    """Holds the folder for this process: another process that measures into it waits."""
    try:
        import fcntl

        handle = os.open(folder, os.O_RDONLY)
    except (ImportError, OSError):  # Windows, or a folder that cannot be listed
        yield
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        note("waits for another process, which measures into the same folder")
        fcntl.flock(handle, fcntl.LOCK_EX)
    except OSError:
        pass  # a file system without locks
    try:
        yield
    finally:
        os.close(handle)


def key_of(*what: Any) -> str:
    """A hash of the inputs of a result (dataclasses and JSON values) and of plumbob's sources."""
    text = json.dumps([unstructured(item) for item in what], sort_keys=True)
    return hashlib.sha256(f"{_source()}{text}".encode()).hexdigest()


@cache
def _source() -> str:
    """A hash of plumbob's files that change results. The version number does not do: a tree between
    two releases has the number of the last release."""
    root = Path(__file__).parents[2]
    digest = hashlib.sha256()
    for folder in SOURCES:
        for file in sorted((root / folder).rglob("*")):
            if file.suffix in (".py", ".xml", ".toml") and file.is_file():
                digest.update(f"{file.relative_to(root)}\0".encode() + file.read_bytes())
    return digest.hexdigest()
