"""The files that results are stored in: opened to read or to write, and what is none refused.

Readers open it read-only and change no byte of it. Nothing in it is run: a file with triggers or
views, or with tables of another shape than ours, is refused.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from plumbob.analytic.parameters import ParameterError

FILE = "studies.sqlite3"  # its name in a folder of results
SCHEMA = 6  # of the tables and of the JSON in them; 5 had no steps that are drawn
PATIENCE = 5.0  # [s] to wait for another process that has locked the file
STUDIES = """
create table if not exists study (
    id integer primary key, created text not null, profile text not null, body text not null);
create table if not exists scene (
    study integer not null references study, name text not null, body text not null,
    observables text not null, quantities text not null);
create table if not exists method (study integer not null references study, body text not null);
create table if not exists convergence_study (
    study integer not null references study, scene text not null, method text not null,
    body text not null, cost text);
create table if not exists run (
    study integer not null references study, scene text not null, method text not null,
    step real not null, status text not null, body text not null);
create table if not exists extra (
    study integer not null references study, kind text not null, request text not null,
    result text, arrays blob);
create table if not exists checksum (
    study integer not null references study, part text not null, scene text not null,
    digest text not null, primary key (study, part, scene));
create index if not exists run_of on run (study, scene, method);
"""
# What is measured of studies that are not complete: a file without these has none.
UNFINISHED = """
create table if not exists unfinished (
    id integer primary key, plan text not null, created text not null, study integer,
    complete integer not null);
create table if not exists piece (
    unfinished integer not null references unfinished, key text not null, label text not null,
    owner integer, state text not null, seconds real, body text, primary key (unfinished, key));
create table if not exists piece_extra (
    unfinished integer not null references unfinished, key text not null, kind text not null,
    request text not null, result text, arrays blob);
create index if not exists extra_of on piece_extra (unfinished, key);
"""


@dataclass(frozen=True)
class Kind:
    """What is stored in a file: its name in messages, its schema, and its tables as SQL."""

    holds: str
    schema: int
    tables: str  # that each of them has
    more: str = ""  # that are made where it is written to


STORED_STUDIES = Kind("stored studies", SCHEMA, STUDIES, UNFINISHED)


@contextmanager
def reading(file: Path) -> Iterator[sqlite3.Connection]:
    """A connection to an existing store that cannot change it; raises ParameterError for a file
    that is no store, is damaged or locked, or is of another version."""
    # Rows are fetched before they are read: a cursor left half-way by an error would keep a lock.
    with _one_line(file, STORED_STUDIES), decoding():
        _regular(file, STORED_STUDIES)
        try:
            with closing(_connection(file, "ro")) as store:
                _ours(store, file, STORED_STUDIES)
        except sqlite3.OperationalError as error:
            # What Python itself raises, as of a text that is no UTF-8, has no code.
            if getattr(error, "sqlite_errorcode", 0) != sqlite3.SQLITE_READONLY_ROLLBACK:
                raise
            _rolled_back(file)
        with closing(_connection(file, "ro")) as store:
            _ours(store, file, STORED_STUDIES)
            yield store


@contextmanager
def writing(file: Path, kind: Kind = STORED_STUDIES) -> Iterator[sqlite3.Connection]:
    """A connection to a store, made if need be, without an open transaction; raises ParameterError
    as `reading` does, and for a file that cannot be written."""
    with _one_line(file, kind):
        if os.path.lexists(file):
            _regular(file, kind)
            if not os.access(file, os.W_OK):
                raise ParameterError("store", str(file), "a file that can be written to")
        with closing(_connection(file, "rwc")) as store:
            new = not _ours(store, file, kind)
            (found,) = store.execute("pragma quick_check(1)").fetchone()
            if found != "ok":
                raise sqlite3.DatabaseError(found)
            with transaction(store):
                for statement in f"{kind.tables}{kind.more}".split(";"):
                    store.execute(statement)
                if new:
                    store.execute(f"pragma user_version = {kind.schema}")
            yield store


@contextmanager
def transaction(store: sqlite3.Connection) -> Iterator[None]:
    """What is written within is there as a whole, or not at all."""
    store.execute("begin immediate")
    try:
        yield
        store.execute("commit")
    except BaseException:
        if store.in_transaction:
            store.execute("rollback")
        raise


def _connection(file: Path, mode: str) -> sqlite3.Connection:
    name = quote(os.fsencode(os.path.abspath(file)))
    store = sqlite3.connect(
        f"file:{name}?mode={mode}", uri=True, timeout=PATIENCE, isolation_level=None
    )
    store.execute("pragma trusted_schema = off")
    return store


def _regular(file: Path, kind: Kind) -> None:
    if not file.is_file():
        raise ParameterError("store", str(file), f"a regular file, a file of {kind.holds}")


def _rolled_back(file: Path) -> None:
    """Undo a transaction that was cut off, as any writer does that comes next."""
    with closing(_connection(file, "rw")) as store:
        store.execute("pragma user_version").fetchone()
        store.execute("select count(*) from sqlite_master").fetchone()


def _ours(store: sqlite3.Connection, file: Path, kind: Kind) -> bool:
    """Whether there are the tables of this kind, and False for an empty file; raises ParameterError
    for a file of another schema, or with anything in it that is not ours."""
    query = "select type, name, sql from sqlite_master where name not like 'sqlite^_%' escape '^'"
    store.execute("begin")  # another process may make the tables between two reads
    try:
        (schema,) = store.execute("pragma user_version").fetchone()
        there = {(what, name): sql for what, name, sql in store.execute(query).fetchall()}
    finally:
        store.execute("rollback")
    if not there and not schema:
        return False
    if schema == 0 and ("table", "study") in there:  # from before schemas had numbers
        schema = 1
    if schema == 0:
        raise ParameterError("store", str(file), f"a file of {kind.holds} (it holds other data)")
    if schema != kind.schema:
        which = "an older" if 0 < schema < kind.schema else "a newer"
        raise ParameterError(
            "store", str(file),
            f"written by this version of plumbob (schema {kind.schema}), and is by {which} one "
            f"(schema {schema}): take another folder with --out, or measure again",
        )  # fmt: skip
    wanted = _as_made(kind.tables + kind.more)
    for (what, name), sql in there.items():
        if (what, name) not in wanted or _plain(sql) != _plain(wanted[what, name]):
            alone = f"a file of {kind.holds} alone (it holds the {what} {name!r})"
            raise ParameterError("store", str(file), alone)
    for what, name in _as_made(kind.tables):
        if (what, name) not in there:
            missing = f"a file of {kind.holds} (the {what} {name!r} is missing)"
            raise ParameterError("store", str(file), missing)
    return True


def _as_made(tables: str) -> Mapping[tuple[str, str], str]:
    """Every table and index, as SQLite keeps its definition."""
    with closing(sqlite3.connect(":memory:")) as made:
        made.executescript(tables)
        query = "select type, name, sql from sqlite_master where sql is not null"
        return {(what, name): sql for what, name, sql in made.execute(query).fetchall()}


def _plain(sql: str | None) -> str:
    return " ".join((sql or "").split())


@contextmanager
def _one_line(file: Path, kind: Kind) -> Iterator[None]:
    """What SQLite says of a file, as a ParameterError."""
    try:
        yield
    except sqlite3.DatabaseError as error:
        raise ParameterError("store", str(file), _needed(error, kind)) from None


@contextmanager
def decoding() -> Iterator[None]:
    """A row that cannot be read back is what a damaged file is to SQLite."""
    try:
        yield
    except ParameterError:
        raise
    except (ValueError, RecursionError) as error:
        raise sqlite3.DatabaseError(str(error)) from None


def _needed(error: sqlite3.DatabaseError, kind: Kind) -> str:
    """What a file must be where SQLite raised this."""
    code = getattr(error, "sqlite_errorcode", 0) & 0xFF
    if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
        return "a file that no other process has locked (try again)"
    if code == sqlite3.SQLITE_READONLY:
        return f"a file that can be written to ({error})"
    if code in (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR):
        return f"on a disk with free space that can be written to ({error})"
    if code in (sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_PERM, sqlite3.SQLITE_AUTH):
        return f"a file that can be opened ({error})"
    if code == sqlite3.SQLITE_CORRUPT:
        return f"a whole file of {kind.holds} ({error})"
    return f"a file of {kind.holds} ({error})"
