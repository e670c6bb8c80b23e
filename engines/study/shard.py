"""Shards: parts of a plan that are measured apart, each into a folder, and merged afterwards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from plumbob.analytic.parameters import ParameterError

PlanPart = TypeVar("PlanPart", str, int)  # name or number of a part of a plan
SHARD_FOLDERS = "OUT"  # name of the folders of shards in messages


@dataclass(frozen=True)
class Shard:
    """One of several shards of a plan."""

    number: int  # counted from 1
    count: int

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"

    def parts(self, work: Mapping[PlanPart, float]) -> frozenset[PlanPart]:
        """Returns the parts of a plan that this shard measures. `work` is the work of each part, in
        any unit. The part with most work goes first, to the shard with least work so far: all
        shards divide the plan in the same way, and take about as long."""
        loads = [0.0] * self.count
        own = set[PlanPart]()
        for part in sorted(work, key=lambda part: (-work[part], part)):
            least = loads.index(min(loads))
            loads[least] += work[part]
            if least == self.number - 1:
                own.add(part)
        return frozenset(own)


@dataclass(frozen=True)
class MeasuredShard:
    """A shard that is measured to its end: its plan, its versions, and its results by their
    keys."""

    shard: Shard
    plan: str  # key of the whole plan
    sources: str  # hash of plumbob's files that change results
    versions: Mapping[str, str]  # versions of packages that change results
    keys: tuple[str, ...]


def check_shards(shards: Sequence[tuple[Path, MeasuredShard]], sources: str) -> None:
    """Raises ParameterError unless these shards, each with its folder, are all shards of one plan,
    each once, measured with the same versions and with plumbob's `sources`."""
    first_folder, first = shards[0]
    for folder, shard in shards:
        if shard.sources != sources:
            raise _misfit(folder, "measured by this plumbob: its files have changed since")
        for package in sorted({*first.versions, *shard.versions}):
            wanted, there = (of.versions.get(package, "none") for of in (first, shard))
            if there != wanted:
                expected = f"measured with {package} {wanted} as {first_folder}, not {there}"
                raise _misfit(folder, expected)
        if (shard.plan, shard.shard.count) != (first.plan, first.shard.count):
            raise _misfit(folder, f"a shard of the same plan as {first_folder}")
    folders = dict[int, Path]()
    for folder, shard in shards:
        number = shard.shard.number
        if number in folders:
            raise _misfit(
                folder, f"another shard than {folders[number]}: both are {shard.shard}"
            )
        folders[number] = folder
    missing = [n for n in range(1, first.shard.count + 1) if n not in folders]
    if missing:
        names = ", ".join(str(Shard(number, first.shard.count)) for number in missing)
        given = ", ".join(map(str, dict.fromkeys(folders.values())))
        raise ParameterError(SHARD_FOLDERS, given, f"all shards of a plan; missing: {names}")


def damaged_shard(folder: Path, shard: Shard) -> ParameterError:
    """Returns the error for a folder in which a result of a shard is damaged."""
    return _misfit(folder, f"as it was stored: measure shard {shard} again")


def _misfit(folder: Path, expected: str) -> ParameterError:
    """Returns the error for a folder whose shard does not fit."""
    return ParameterError(SHARD_FOLDERS, str(folder), expected)
