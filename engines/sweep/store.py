"""Sweeps and searches kept in a file: each piece when it is done, known by what defines it."""

from __future__ import annotations

import hashlib
import json
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import engine_of
from plumbob.engines.study.codec import to_json
from plumbob.engines.study.provenance import provenance
from plumbob.engines.sweep.sweep import Chunk, Keep, Sweep
from plumbob.engines.sweep.worst import Found

FILE = "sweeps.sqlite3"  # its name in a folder of results
APPLICATION, SCHEMA = 0x706C7377, 1
WAIT = 30.0  # [s] for another process that is writing
_TABLES = """
create table sweep (
    key text primary key, sweep text not null, provenance text not null) strict;
create table chunk (
    sweep text not null references sweep, number integer not null, errors blob not null,
    reasons text not null, primary key (sweep, number)) strict;
create table worst (
    key text primary key, found text not null, provenance text not null) strict;
"""


def key_of(asked: Sweep) -> str:
    """What a sweep is known by: a hash of all that its figures depend on."""
    packages = {engine_of(m).package for m in asked.methods} | {"numpy", "scipy", "plumbob"}
    versions = {n: v for n, v in provenance("").versions.items() if n in packages}
    text = json.dumps([json.loads(to_json(asked)), sorted(versions.items())], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def begun(file: Path, asked: Sweep, command: str) -> Mapping[int, Chunk]:
    """The pieces of a sweep that are there already; the sweep is entered where it is new. Raises
    ParameterError for a file that is no store of sweeps."""
    key, shape = key_of(asked), (len(asked.methods), len(asked.steps), -1)
    with _opened(file) as store, store:
        store.execute(
            "insert or ignore into sweep values (?, ?, ?)",
            (key, to_json(asked), to_json(provenance(command))),
        )
        query = "select number, errors, reasons from chunk where sweep = ?"
        return {
            number: Chunk(np.frombuffer(errors, "<f8").reshape(shape), json.loads(reasons))
            for number, errors, reasons in store.execute(query, (key,)).fetchall()
        }


@contextmanager
def keeping(file: Path, asked: Sweep) -> Iterator[Keep]:
    """What keeps a piece of a sweep, which is there for good once it returns."""
    key = key_of(asked)
    with _opened(file) as store:

        def keep(number: int, chunk: Chunk) -> None:
            with store:
                store.execute(
                    "insert or ignore into chunk values (?, ?, ?, ?)",
                    (
                        key,
                        number,
                        chunk.errors.astype("<f8").tobytes(),
                        json.dumps(dict(chunk.reasons)),
                    ),
                )

        yield keep


def keep_worst(file: Path, found: Found, command: str) -> None:
    """Keep what a search found, in place of what a search for the same gave before."""
    defined = [to_json(found.box), found.method, found.step, found.runs]
    key = hashlib.sha256(json.dumps(defined).encode()).hexdigest()[:16]
    with _opened(file) as store, store:
        store.execute(
            "insert or replace into worst values (?, ?, ?)",
            (key, to_json(found), to_json(provenance(command))),
        )


@contextmanager
def _opened(file: Path) -> Iterator[sqlite3.Connection]:
    """The store, made if need be; raises ParameterError for another file, which is not touched."""
    try:
        if file.exists() and not file.is_file():
            raise ValueError("no regular file")
        file.parent.mkdir(parents=True, exist_ok=True)
        with closing(sqlite3.connect(file, timeout=WAIT)) as store:
            _ours(store, file)
            yield store
    except (sqlite3.Error, ValueError) as error:
        if isinstance(error, ParameterError):
            raise
        raise ParameterError("store", str(file), f"a file of sweeps ({error})") from error


def _ours(store: sqlite3.Connection, file: Path) -> None:
    """Make the tables of a new file; raises ParameterError for one that is not ours, or not of this
    version."""
    query = "select distinct type from sqlite_master"
    store.execute("begin immediate")  # another process may make the tables meanwhile
    with store:
        (application,) = store.execute("pragma application_id").fetchone()
        (schema,) = store.execute("pragma user_version").fetchone()
        things = {kind for (kind,) in store.execute(query).fetchall()}
        if not things and not application and not schema:
            for statement in _TABLES.split(";"):
                store.execute(statement)
            store.execute(f"pragma application_id = {APPLICATION}")
            store.execute(f"pragma user_version = {SCHEMA}")
        elif (application, schema) != (APPLICATION, SCHEMA) or things & {"trigger", "view"}:
            raise ParameterError("store", str(file), "a file of sweeps of this version of plumbob")
