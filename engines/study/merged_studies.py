"""Several stored studies of one scene as one: all runs with the installed versions."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from plumbob.engines.registry import engines
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.cost import Cost, Key
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.provenance import changed_since
from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene

SEARCH = "search"  # the profile of runs at steps that are no convergence study


@dataclass(frozen=True)
class LeftOut:
    """Runs that are not counted: with which version, when, and how many."""

    version: str  # "mujoco 2.0.0"
    date: str
    runs: int

    def __str__(self) -> str:
        return f"{self.runs} runs measured with {self.version} ({self.date or 'no date'})"


def with_installed_versions(study: Study) -> tuple[Study, tuple[LeftOut, ...]]:
    """A study without the runs whose engine has another version now, and what was left out."""
    changed = {
        entry.partition(" ")[0]: entry.partition(",")[0]
        for entry in changed_since(study.provenance)
    }
    old = {
        m.name: changed[package]
        for m in study.methods
        if m.engine in engines() and (package := _package(m.engine)) in changed
    }
    counted = Counter[str]()
    for c in study.convergence:
        if c.method in old:
            counted[old[c.method]] += len(c.measurements)
    kept = study.of_methods([m.name for m in study.methods if m.name not in old])
    date = study.provenance.date
    return kept, tuple(LeftOut(version, date, runs) for version, runs in counted.items())


def merged(studies: Sequence[Study], scene: Scene | None = None) -> Study | None:
    """The convergence studies of one scene as one study, the oldest first: of runs at one step, and
    of costs, the newest. What has the parameters of another scene of that name, or another
    definition of a method, than `scene` or the newest study is left out; None where nothing is
    left."""
    wanted = scene if scene is not None else (studies[-1].scenes[0] if studies else None)
    same = [s for s in studies if wanted is not None and _same(s.scenes[0], wanted)]
    if wanted is None or not same:
        return None
    methods = {m.name: m for study in same for m in study.methods}
    together: dict[Key, ConvergenceStudy] = {}
    costs: dict[Key, Cost] = {}
    unit = next((s.reference_step for s in reversed(same) if s.costs), math.nan)
    for study in same:
        present = study.of_methods([m.name for m in study.methods if m == methods[m.name]])
        for c in present.convergence:
            key = c.scene, c.method
            together[key] = _joined(together[key], c) if key in together else c
        for key, cost in present.costs.items():
            costs[key] = cost.scaled(unit / study.reference_step)
    return replace(
        same[-1],
        scenes=(wanted,),
        methods=tuple(methods.values()),
        convergence=tuple(together.values()),
        costs=costs,
        reference_step=unit,
        extras={of: answer for study in same for of, answer in study.extras.items()},
    )


def searched_runs(studies: Sequence[Study], scene: Scene) -> dict[str, list[Measurement]]:
    """Runs of a scene at steps that are no convergence study, by method, the oldest first."""
    found: dict[str, list[Measurement]] = {}
    for study in studies:
        if _same(study.scenes[0], scene):
            for c in study.convergence:
                found.setdefault(c.method, []).extend(c.measurements)
    return found


def _package(engine: str) -> str:
    """The package whose version counts: the engine's, or the one that adds it to plumbob."""
    found = engines()[engine]
    return found.distribution or found.package


def _same(one: Scene, other: Scene) -> bool:
    """Whether two scenes of one name are the same motion; their step sizes may differ."""
    return (dict(one.parameters), one.duration) == (dict(other.parameters), other.duration)


def _joined(old: ConvergenceStudy, new: ConvergenceStudy) -> ConvergenceStudy:
    """Both studies' runs, coarse to fine, the newer where both ran a step; beside the step sizes
    are those that no study has among them."""
    runs = {m.step: m for m in (*old.measurements, *new.measurements)}
    sizes = {m.step for c in (old, new) for m in c.measurements if m.step not in c.beside}
    more = new if len(new.measurements) >= len(old.measurements) else old
    ordered = tuple(runs[step] for step in sorted(runs, reverse=True))
    beside = tuple(sorted({*old.beside, *new.beside} - sizes, reverse=True))
    return replace(more, measurements=ordered, cut=old.cut and new.cut, beside=beside)
