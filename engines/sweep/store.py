"""Sweeps and searches stored in a file: each chunk when it is done, under a hash of its inputs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from plumbob.engines.study import store
from plumbob.engines.study.checkpoint import key_of
from plumbob.engines.study.provenance import versions_of
from plumbob.engines.study.store_file import writing
from plumbob.engines.sweep.sweep import Chunk, Keep, Sweep
from plumbob.engines.sweep.worst import Found

FILE = "sweeps.sqlite3"  # name of the file in a folder of results


def key_of_sweep(asked: Sweep) -> str:
    """The key of a sweep: a hash of everything on which its results depend."""
    return key_of("sweep", asked, [versions_of(method) for method in asked.methods])


@contextmanager
def keeping(file: Path, asked: Sweep) -> Iterator[tuple[Mapping[int, Chunk], Keep]]:
    """The stored chunks of a sweep by number, and a function that stores another chunk before it
    returns. Raises ParameterError if the file is no store."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with writing(file) as opened:
        number, _ = store.begun(opened, key_of_sweep(asked))
        there = store.stored_results(opened, number, map(str, range(asked.chunks)), Chunk)

        def keep(chunk: int, found: Chunk) -> None:
            store.keep(opened, number, {str(chunk): found})

        yield {int(key): chunk for key, chunk in there.items()}, keep


def keep_worst(file: Path, found: Found) -> None:
    """Stores the result of a search; it replaces an earlier result of the same search."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with writing(file) as opened:
        key = key_of("worst", found.box, found.method, found.step, found.runs)
        store.keep(opened, store.begun(opened, key)[0], {"worst": found})
