"""Sweeps and searches stored in a file: each chunk when it is done, under a hash of its inputs."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from sqlite3 import Connection

from plumbob.engines.study import store
from plumbob.engines.study.checkpoint import key_of, measured_shard
from plumbob.engines.study.provenance import versions_of
from plumbob.engines.study.shard import Shard, check_shards
from plumbob.engines.study.store_file import reading_connection, writing
from plumbob.engines.sweep.sweep import Chunk, Keep, Sweep, Swept, assembled_sweep
from plumbob.engines.sweep.worst import Found

FILE = "sweeps.sqlite3"  # name of the file in a folder of results
REQUEST = "sweep"  # key of the row with the sweep that was asked for


def key_of_sweep(request: Sweep) -> str:
    """The key of a sweep: a hash of everything on which its results depend."""
    versions = [versions_of(method) for method in request.methods]
    return key_of("sweep", request, versions)


@contextmanager
def keeping(file: Path, request: Sweep) -> Iterator[tuple[Mapping[int, Chunk], Keep]]:
    """The stored chunks of a sweep by number, and a function that stores another chunk before it
    returns. Raises ParameterError if the file is no store."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with writing(file) as opened:
        study, _ = store.study_number(opened, key_of_sweep(request))
        stored_chunks = _stored_chunks(opened, study, request)
        if not store.stored_results(opened, study, (REQUEST,), Sweep):
            store.keep(opened, study, {REQUEST: request})

        def keep(number: int, chunk: Chunk) -> None:
            """Stores the chunk with this number."""
            store.keep(opened, study, {str(number): chunk})

        yield stored_chunks, keep


def _stored_chunks(opened: Connection, study: int, request: Sweep) -> Mapping[int, Chunk]:
    """The stored chunks of a sweep, which has a number of its own in an open store, by number."""
    keys = map(str, range(request.chunks))
    chunks = store.stored_results(opened, study, keys, Chunk)
    return {int(key): chunk for key, chunk in chunks.items()}


def stored_sweeps(file: Path) -> list[Swept]:
    """Returns the sweeps in a store, the oldest first, with the chunks that are stored. Sweeps that
    an earlier version stored without their request are left out. Raises ParameterError if the file
    is no store."""
    sweeps = []
    with reading_connection(file) as opened:
        for study in store.numbers_with(opened, REQUEST):
            for request in store.stored_results(opened, study, (REQUEST,), Sweep).values():
                chunks = _stored_chunks(opened, study, request)
                sweeps.append(assembled_sweep(request, chunks))
    return sweeps


def keep_sweep_shard(file: Path, request: Sweep, shard: Shard, chunks: Collection[int]) -> None:
    """Stores that a shard of a sweep, which consists of these chunks, is measured to its end."""
    key = key_of_sweep(request)
    with writing(file) as opened:
        number, _ = store.study_number(opened, key)
        keys = map(str, sorted(chunks))
        store.keep_shard(opened, number, measured_shard(shard, key, keys))


def merged_sweep(folders: Sequence[Path], out: Path) -> tuple[Swept, str]:
    """Returns the sweep whose shards are stored in `folders`, and its key; stores it in the folder
    `out`. Raises ParameterError if the shards do not make up one sweep."""
    shards: list[store.StoredShard[Sweep, Chunk]] = []
    for folder in folders:
        shards += store.stored_shards(folder / FILE, REQUEST, Sweep, Chunk)
    check_shards([(shard.folder, shard.measured) for shard in shards], key_of())
    request, key = shards[0].whole, shards[0].measured.plan
    chunks = dict[int, Chunk]()
    for shard in shards:
        chunks |= {int(number): chunk for number, chunk in shard.results.items()}
    with writing(out / FILE) as opened:
        number, _ = store.study_number(opened, key)
        by_key = {str(place): chunks[place] for place in sorted(chunks)}
        store.keep(opened, number, {REQUEST: request, **by_key})
    return assembled_sweep(request, chunks), key


def keep_worst(file: Path, worst: Found) -> None:
    """Stores the result of a search; it replaces an earlier result of the same search."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with writing(file) as opened:
        key = key_of("worst", worst.box, worst.method, worst.step, worst.runs)
        study, _ = store.study_number(opened, key)
        store.keep(opened, study, {"worst": worst})
