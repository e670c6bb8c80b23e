"""Results of a study that is not complete: each kept at once, under a hash of what defines it."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from functools import cache
from pathlib import Path
from sqlite3 import Connection, connect
from typing import Any

from plumbob.engines.study import store
from plumbob.engines.study.codec import plain
from plumbob.engines.study.results import Study, TaskResult
from plumbob.engines.study.store_file import create, writing

SOURCES = ("analytic", "models", "engines")  # folders whose files decide what is measured
Note = Callable[[str], None]


class Checkpoint:
    """The results of the study that is measured into an open store."""

    def __init__(self, opened: Connection, fresh: bool, note: Note) -> None:
        self._store, self._fresh, self._note = opened, fresh, note
        self.number = 0
        self.given_up: tuple[str, ...] = ()  # each with its reason

    def begin(self, plan: str, keys: Sequence[str]) -> bool:
        """Begin, or go on with, the study of this plan, which consists of these results and costs
        that follow from them; tells whether it was begun before."""
        if self._fresh:
            store.forget(self._store, plan)
        self.number, before = store.begun(self._store, plan)
        if count := len(self.there(keys)):
            self._note(f"goes on: {count} of {len(keys)} results are there")
        return before

    def there(self, keys: Sequence[str]) -> dict[str, TaskResult]:
        """Those of the results that are there, but for what was given up."""
        found = store.results(self._store, self.number, keys, TaskResult)
        return {key: result for key, result in found.items() if not result.lost}

    def keep(self, results: Mapping[str, TaskResult]) -> None:
        """Keep results by their keys, in one transaction."""
        store.keep(self._store, self.number, results)

    def complete(self, study: Study, results: Mapping[str, TaskResult]) -> None:
        """The study has these results, and no others; the same command tries again what was given
        up, if anything."""
        self.given_up = tuple(f"{r.label}: {r.lost}" for r in results.values() if r.lost)
        store.complete(self._store, self.number, study, results, bool(self.given_up))


class SharedResults(Checkpoint):
    """Results that belong to no study: whoever asks for one by its key takes it, from a file of
    `studies` too; nothing is begun or completed."""

    def __init__(self, opened: Connection, studies: Path, note: Note) -> None:
        super().__init__(opened, False, note)
        self._studies = studies
        self.number, _ = store.begun(opened, "")

    def begin(self, plan: str, keys: Sequence[str]) -> bool:
        """Nothing is begun."""
        return False

    def there(self, keys: Sequence[str]) -> dict[str, TaskResult]:
        """Those of the results that are there, or in a study."""
        found = super().there(keys)
        missing = [key for key in keys if key not in found]
        if missing and os.path.lexists(self._studies):
            found |= store.in_any_study(self._studies, missing)
        return found

    def complete(self, study: Study, results: Mapping[str, TaskResult]) -> None:
        """Nothing is completed."""


@contextmanager
def shared_results(file: Path | None, studies: Path, note: Note) -> Iterator[SharedResults]:
    """The shared results in `file`, made if need be, or without one in memory; raises
    ParameterError as `measured_into`."""
    with _opened(file, note) as opened:
        yield SharedResults(opened, studies, note)


@contextmanager
def measured_into(
    file: Path | None, fresh: bool = False, note: Note = lambda _: None
) -> Iterator[Checkpoint]:
    """The checkpoint in the store `file`, made if need be, or without one in memory; `fresh` begins
    a new study where one is not complete, `note` is given what a user wants to know, such as
    which older studies are damaged. Raises ParameterError for a file that is no store or cannot be
    written."""
    with _opened(file, note) as opened:
        for why in store.damages(opened):
            note(f"{file}: {why}")
        yield Checkpoint(opened, fresh, note)


@contextmanager
def _opened(file: Path | None, note: Note) -> Iterator[Connection]:
    if file is None:
        with closing(connect(":memory:", isolation_level=None)) as opened:
            create(opened)
            yield opened
        return
    with _alone(file.parent, note), writing(file) as opened:
        yield opened


@contextmanager
def _alone(folder: Path, note: Note) -> Iterator[None]:
    """One process measures into a folder: another one waits until it has ended."""
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
    """The hash of what defines a result: dataclasses, and what JSON knows."""
    text = json.dumps([plain(one) for one in what], sort_keys=True)
    return hashlib.sha256(f"{_source()}{text}".encode()).hexdigest()


@cache
def _source() -> str:
    """The hash of plumbob's own files that decide what is measured: a version between two releases
    has the number of the last."""
    root = Path(__file__).parents[2]
    digest = hashlib.sha256()
    for folder in SOURCES:
        for file in sorted((root / folder).rglob("*")):
            if file.suffix in (".py", ".xml", ".toml") and file.is_file():
                digest.update(f"{file.relative_to(root)}\0".encode() + file.read_bytes())
    return digest.hexdigest()
