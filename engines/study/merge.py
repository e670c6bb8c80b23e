"""Merges the shards of a study into the whole study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from plumbob.engines.study import store
from plumbob.engines.study.checkpoint import WHOLE, Checkpoint, key_of
from plumbob.engines.study.results import Study, TaskResult
from plumbob.engines.study.runner import Analyse, complete_study
from plumbob.engines.study.shard import MeasuredShard, check_shards, damaged_shard
from plumbob.engines.study.store_file import reading_connection
from plumbob.engines.workers import Workers


@dataclass(frozen=True)
class _StudyShard:
    """A stored shard of a study."""

    folder: Path
    measured: MeasuredShard
    whole: store.Listed  # tasks of the whole study; keys of tasks of other shards may differ
    results: dict[str, TaskResult]


def merged_study(
    folders: Sequence[Path],
    kept: Checkpoint,
    workers: Workers,
    analyse: Analyse,
) -> Study:
    """Returns the study whose shards are stored in `folders`, and stores it. Raises ParameterError
    if the shards do not make up one study."""
    shards = [shard for folder in folders for shard in _shards_in(folder)]
    check_shards([(shard.folder, shard.measured) for shard in shards], key_of())
    head = _head_of(shards)
    results = _in_order(shards, [scene.name for scene in head.scenes])
    kept.begin(shards[0].measured.plan, ())
    kept.keep(results)
    return complete_study(head, results, kept, workers, analyse)


def _shards_in(folder: Path) -> list[_StudyShard]:
    """Returns the shards of the newest study in a folder. Raises ParameterError if one is
    damaged."""
    shards = []
    with reading_connection(folder / store.FILE) as opened:
        number, measured_shards = store.newest_shards(opened)
        whole = store.stored_results(opened, number, [WHOLE], store.Listed).get(WHOLE)
        for measured in measured_shards:
            results = store.stored_results(opened, number, measured.keys, TaskResult)
            if whole is None or len(results) < len(measured.keys):
                raise damaged_shard(folder, measured.shard)
            shards.append(_StudyShard(folder, measured, whole, results))
    return shards


def _head_of(shards: Sequence[_StudyShard]) -> Study:
    """Returns the study without results; its machine names the machines of all shards."""
    heads = [shard.whole.study for shard in shards]
    provenance = heads[0].provenance
    machine = dict[str, str]()
    for name in provenance.machine:
        values = dict.fromkeys(head.provenance.machine.get(name, "") for head in heads)
        machine[name] = "; ".join(values)
    return replace(heads[0], provenance=replace(provenance, machine=machine))


def _in_order(shards: Sequence[_StudyShard], scenes: Sequence[str]) -> dict[str, TaskResult]:
    """Returns the results of all shards by their keys, in the order in which a study without shards
    has them: its tasks, then the costs of its scenes. The key of a timed task names the machine,
    hence a task is known by its place in the list."""
    results = dict[str, TaskResult]()
    costs = dict[str, TaskResult]()
    for tasks in zip(*(shard.whole.results for shard in shards), strict=True):
        for shard, (key, _) in zip(shards, tasks, strict=True):
            if key in shard.results:
                results[key] = shard.results[key]
    for shard in shards:
        costs |= {key: of for key, of in shard.results.items() if key not in results}
    order = sorted(costs, key=lambda key: scenes.index(costs[key].scene))
    return results | {key: costs[key] for key in order}
