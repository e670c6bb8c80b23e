"""Opens the files of stored results to read or to write, and refuses other files.

Reading changes no byte of a file. Nothing in a file is executed: a file with triggers, views, or
other tables than the table of results is refused.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from urllib.parse import quote

from plumbob.analytic.parameters import ParameterError
from plumbob.models.border import border

FILE = "studies.sqlite3"  # name of the file in a folder of results
SCHEMA = 10  # version of the table and of the JSON in it
INSTEAD = "move it away, or take another folder with --out"
LOCK_WAIT = 5.0  # [s] longest wait for another process that has locked the file
HOLDS = "a file of stored results"
TABLE = """create table result (
    study integer not null, key text not null, body text not null, digest text not null,
    primary key (study, key))"""


@contextmanager
def reading_connection(file: Path) -> Iterator[sqlite3.Connection]:
    """A connection to an existing store that cannot change the store. Raises ParameterError if the
    file is no store, is damaged or locked, or is of another version."""
    # Rows are fetched before they are read: a cursor left half-way by an error would keep a lock.
    with _one_line(file), decoding():
        _regular(file)
        # If the file may be written to, SQLite undoes a transaction that was cut off.
        mode = "rw" if os.access(file, os.W_OK) else "ro"
        with closing(_connection(file, mode)) as store:
            store.execute("pragma query_only = on")
            _ours(store, file)
            yield store


@contextmanager
def writing(file: Path) -> Iterator[sqlite3.Connection]:
    """A connection to a store, which is made if there is none, without an open transaction. Raises
    ParameterError as `reading_connection` does, and if the file cannot be written."""
    with _one_line(file):
        if os.path.lexists(file):
            _regular(file)
            if not os.access(file, os.W_OK):
                raise ParameterError("store", str(file), "a file that can be written to")
        with closing(_connection(file, "rwc")) as store:
            new = not _ours(store, file)
            (found,) = store.execute("pragma quick_check(1)").fetchone()
            if found != "ok":
                raise sqlite3.DatabaseError(f"{found}; {INSTEAD}")
            if new:
                create(store)
            yield store


@contextmanager
def transaction(store: sqlite3.Connection, how: str = "immediate") -> Iterator[None]:
    """A transaction: rows written within it are stored all together or not at all. A transaction
    within another one is part of it."""
    if store.in_transaction:
        yield
        return
    store.execute(f"begin {how}")
    try:
        yield
        store.execute("commit")
    except BaseException:
        if store.in_transaction:
            store.execute("rollback")
        raise


def _connection(file: Path, mode: str) -> sqlite3.Connection:
    """A connection to a file in one of SQLite's modes: "ro", "rw" or "rwc"."""
    name = quote(os.fsencode(os.path.abspath(file)))
    store = sqlite3.connect(
        f"file:{name}?mode={mode}", uri=True, timeout=LOCK_WAIT, isolation_level=None
    )
    # Damaged text is read, too, instead of raising an exception.
    store.text_factory = partial(str, encoding="utf-8", errors="replace")
    store.execute("pragma trusted_schema = off")
    return store


def _regular(file: Path) -> None:
    """Raises ParameterError if a path is no regular file."""
    if not file.is_file():
        raise ParameterError("store", str(file), f"a regular file, {HOLDS}")


def create(store: sqlite3.Connection) -> None:
    """Makes the table of results in an empty file."""
    with transaction(store):
        store.execute(TABLE)
        store.execute(f"pragma user_version = {SCHEMA}")


def _ours(store: sqlite3.Connection, file: Path) -> bool:
    """Whether a file has the table of results; False for an empty file. Raises ParameterError if
    the file has another schema, or holds anything else."""
    with transaction(store, "deferred"):  # another process may make the table between two reads
        (schema,) = store.execute("pragma user_version").fetchone()
        query = "select sql from sqlite_master where name not like 'sqlite^_%' escape '^'"
        there = [sql for (sql,) in store.execute(query).fetchall()]
    if not there and not schema:
        return False
    if schema not in (0, SCHEMA):
        which = "an older" if schema < SCHEMA else "a newer"
        raise ParameterError(
            "store",
            str(file),
            f"written by this version of plumbob (schema {SCHEMA}), and is by {which} one "
            f"(schema {schema}): take another folder with --out, or measure again",
        )
    if not schema or [sql.casefold() for sql in there] != [TABLE.casefold()]:
        raise ParameterError("store", str(file), f"{HOLDS} alone (it holds other data)")
    return True


@contextmanager
def _one_line(file: Path) -> Iterator[None]:
    """Turns an error of SQLite into a ParameterError about the file."""
    try:
        yield
    except sqlite3.DatabaseError as error:
        raise ParameterError("store", str(file), _needed(error)) from None


@contextmanager
def decoding() -> Iterator[None]:
    """Turns any exception of decoding a row into the error that SQLite raises for a damaged
    file."""
    with border(sqlite3.DatabaseError, ParameterError, sqlite3.DatabaseError):
        yield


def _needed(error: sqlite3.DatabaseError) -> str:
    """The condition on a file that an error of SQLite shows to be violated."""
    code = getattr(error, "sqlite_errorcode", 0) & 0xFF
    if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
        return "a file that no other process has locked (try again)"
    broken = code in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)
    return f"{HOLDS} ({error}{f'; {INSTEAD}' if broken else ''})"
