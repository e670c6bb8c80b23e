"""The matrix of results, scenes by methods, and the order of systems and engines in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType

from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.records.page_records import SystemRecord
from plumbob.reports.view.method_results import MethodResult, Results

ENGINE_TITLES = MappingProxyType(
    {
        "mujoco": "MuJoCo",
        "pymunk": "pymunk",
        "ode": "ODE solvers",
        "heyoka": "heyoka",
        "exact": "closed form",
    }
)


@dataclass(frozen=True)
class Matrix:
    """The results of all scenes of one kind (rows) by the methods that ran any of them
    (columns)."""

    kind: str
    methods: Sequence[str]
    rows: Sequence[tuple[str, Sequence[MethodResult | None]]]  # scene, one result per method


def order_key(name: str, first: Sequence[str]) -> tuple[int, str]:
    """Returns a sort key that puts the names in `first` first, in that order, and all other names
    after them, alphabetically."""
    return (first.index(name) if name in first else len(first)), name


def sorted_scenes(scenes: Sequence[Scene], systems: Sequence[SystemRecord]) -> Sequence[Scene]:
    """Returns the scenes sorted by their systems, which are in the order of `systems`."""
    names = [system.name for system in systems]
    return sorted(scenes, key=lambda scene: order_key(scene.system, names))


def matrices(study: Study, all_results: Results, scenes: Sequence[Scene]) -> list[Matrix]:
    """Returns one matrix for each kind of scene among `scenes`. A cell is None if the method has no
    error at the reference step of that scene."""
    order = engine_names(study)
    methods = sorted(study.methods, key=lambda m: order.index(m.engine))
    ran = {pair: result for pair, result in all_results.items() if result.at_reference}
    by_kind = []
    for kind in dict.fromkeys(scene.kind for scene in scenes):
        names = [scene.name for scene in scenes if scene.kind == kind]
        columns = [m.name for m in methods if any((scene, m.name) in ran for scene in names)]
        rows = [(scene, [ran.get((scene, name)) for name in columns]) for scene in names]
        by_kind.append(Matrix(kind, columns, rows))
    return by_kind


def too_large_steps(all_results: Results) -> int:
    """Returns the number of cells whose step is too large for the theory although the verdict on
    all steps of the pair of scene and method is another one."""
    return sum(
        result.meaning != "unclaimed" and result.at_reference.meaning == "unclaimed"
        for result in all_results.values()
        if result.at_reference
    )


def engine_names(study: Study) -> list[str]:
    """Returns the names of the study's engines in the order of `ENGINE_TITLES`, then all others
    alphabetically."""
    names = {method.engine for method in study.methods}
    return sorted(names, key=lambda name: order_key(name, [*ENGINE_TITLES]))
