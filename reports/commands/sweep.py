"""plumbob sweep: run methods over a grid of parameters: maps of the error, and the worst points."""

from __future__ import annotations

import argparse
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

from plumbob.engines.registry import method as find_method
from plumbob.reports.commands.arguments import values

if TYPE_CHECKING:
    from plumbob.engines.sweep.sweep import Sweep

INCOMPLETE = 3


def command(chosen: argparse.Namespace) -> int:
    """Runs the points that are not stored yet, prints the errors and writes the page. Returns 3 if
    points are missing."""
    from plumbob.engines.sweep import store
    from plumbob.engines.sweep.sweep import sweep
    from plumbob.reports.commands.arguments.console import note, progress
    from plumbob.reports.commands.shared.shards import check_shard_options, print_shard
    from plumbob.reports.commands.shared.sweep_answer import print_sweep
    from plumbob.reports.view.own_files import check_replaceable
    from plumbob.reports.view.sweep.page import page_name

    check_shard_options(chosen)
    request = _chosen_sweep(chosen)
    chunks: Collection[int] | None = None
    if chosen.shard:
        chunks = chosen.shard.parts(dict.fromkeys(range(request.chunks), 1.0))
    out = Path(chosen.out)
    key = store.key_of_sweep(request)
    check_replaceable("out", out / page_name(request, key))
    with (
        values.workers(chosen) as (executor, jobs),
        progress() as show,
        store.keeping(out / store.FILE, request) as (stored, keep),
    ):

        def show_chunks(finished: int, total: int) -> None:
            show(request.box.scene, finished, total)

        swept = sweep(request, stored, keep, jobs, executor, show_chunks, chunks)
    for number, reason in swept.lost.items():
        first_point = number * request.chunk
        note(f"points from {first_point} on are missing: {reason}")
    if chunks is not None:
        if not swept.lost:
            store.keep_sweep_shard(out / store.FILE, request, chosen.shard, chunks)
        print_shard(chosen, len(chunks) - len(swept.lost), "chunk", len(swept.lost))
    else:
        print_sweep(chosen, swept, key, min(len(stored) * request.chunk, request.points))
    return INCOMPLETE if swept.lost else 0


def _chosen_sweep(chosen: argparse.Namespace) -> Sweep:
    """Returns the whole sweep that the user asks for. Raises ParameterError."""
    from plumbob.engines.box import box
    from plumbob.engines.sweep.sweep import sweep_of

    sides, counts = zip(*chosen.vary, strict=True)
    methods = [find_method(name) for name in dict.fromkeys(chosen.method)]
    steps = list(dict.fromkeys(chosen.step or [values.default_step(methods[0])]))
    with values.representable(chosen.changes):
        parameter_box = box(chosen.scene, chosen.changes, sides)
    shards = chosen.shard.count if chosen.shard else 1
    return sweep_of(parameter_box, counts, methods, steps, shards)
