"""Sweeps and searches kept in a file: each piece when it is done, known by what defines it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from plumbob.engines.study.codec import to_json
from plumbob.engines.study.provenance import provenance, versions_of
from plumbob.engines.study.store_file import Kind, decoding, transaction, writing
from plumbob.engines.study.unfinished import key_of
from plumbob.engines.sweep.sweep import Chunk, Keep, Sweep
from plumbob.engines.sweep.worst import Found

FILE = "sweeps.sqlite3"  # its name in a folder of results
SWEEPS = Kind("sweeps", 1, """
create table if not exists sweep (
    key text primary key, sweep text not null, provenance text not null);
create table if not exists chunk (
    sweep text not null references sweep, number integer not null, errors blob not null,
    reasons text not null, primary key (sweep, number));
create table if not exists worst (
    key text primary key, found text not null, provenance text not null);
""")  # fmt: skip


def key_of_sweep(asked: Sweep) -> str:
    """What a sweep is known by: a hash of all that its figures depend on."""
    return key_of("sweep", asked, [versions_of(method) for method in asked.methods])


def begun(file: Path, asked: Sweep, command: str) -> Mapping[int, Chunk]:
    """The pieces of a sweep that are there already; the sweep is entered where it is new. Raises
    ParameterError for a file that is no store of sweeps."""
    key, shape = key_of_sweep(asked), (len(asked.methods), len(asked.steps), -1)
    file.parent.mkdir(parents=True, exist_ok=True)
    with writing(file, SWEEPS) as store, transaction(store):
        store.execute(
            "insert or ignore into sweep values (?, ?, ?)",
            (key, to_json(asked), to_json(provenance(command))),
        )
        query = "select number, errors, reasons from chunk where sweep = ?"
        with decoding():
            return {
                number: Chunk(np.frombuffer(errors, "<f8").reshape(shape), json.loads(reasons))
                for number, errors, reasons in store.execute(query, (key,)).fetchall()
            }


@contextmanager
def keeping(file: Path, asked: Sweep) -> Iterator[Keep]:
    """What keeps a piece of a sweep, which is there for good once it returns."""
    key = key_of_sweep(asked)
    with writing(file, SWEEPS) as store:

        def keep(number: int, chunk: Chunk) -> None:
            errors, reasons = chunk.errors.astype("<f8").tobytes(), json.dumps(dict(chunk.reasons))
            with transaction(store):
                store.execute(
                    "insert or ignore into chunk values (?, ?, ?, ?)",
                    (key, number, errors, reasons),
                )

        yield keep


def keep_worst(file: Path, found: Found, command: str) -> None:
    """Keep what a search found, in place of what a search for the same gave before."""
    key = key_of("worst", found.box, found.method, found.step, found.runs)
    file.parent.mkdir(parents=True, exist_ok=True)
    with writing(file, SWEEPS) as store, transaction(store):
        store.execute(
            "insert or replace into worst values (?, ?, ?)",
            (key, to_json(found), to_json(provenance(command))),
        )
