"""Merges the shards of a study into the whole study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from plumbob.engines.study import store
from plumbob.engines.study.checkpoint import WHOLE, Checkpoint, key_of
from plumbob.engines.study.results import Study, TaskResult
from plumbob.engines.study.runner import Analyse, complete_study
from plumbob.engines.study.shard import check_shards
from plumbob.engines.workers import Workers

# A shard holds the tasks of the whole study, in which keys of tasks of other shards may differ.
_StudyShard = store.StoredShard[store.Listed, TaskResult]


def merged_study(
    folders: Sequence[Path],
    kept: Checkpoint,
    workers: Workers,
    analyse: Analyse,
) -> Study:
    """Returns the study whose shards are stored in `folders`, and stores it. Raises ParameterError
    if the shards do not make up one study."""
    shards: list[_StudyShard] = []
    for folder in folders:
        shards += store.stored_shards(folder / store.FILE, WHOLE, store.Listed, TaskResult)
    check_shards([(shard.folder, shard.measured) for shard in shards], key_of())
    head = _head_of(shards)
    results = _in_order(shards, [scene.name for scene in head.scenes])
    kept.begin(shards[0].measured.plan, ())
    kept.keep(results)
    return complete_study(head, results, kept, workers, analyse)


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
