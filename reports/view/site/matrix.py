"""Scenes against methods: the order of both, and the results of each pair."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType

from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.view.method_results import MethodResult, Results

ORDER = (
    "cone-pendulum",
    "capsule-line",
    "capsule-turn",
    "capsule-plan",
    "capsule-hold",
    "capsule-coast",
    "capsule-train",
    "simple-pendulum",
    "linear-pendulum",
)
"""Systems in the order in which the sources treat them; others follow by name."""
ENGINES = MappingProxyType(
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
    """Scenes of one kind against the methods that ran any of them."""

    kind: str
    methods: tuple[str, ...]
    rows: tuple[tuple[str, tuple[MethodResult | None, ...]], ...]  # scenes, with a cell a method


def in_order(names: Sequence[str], first: Sequence[str] = ORDER) -> list[str]:
    """Names, of systems in the order of the sources; those that are not among the first after
    them."""
    return sorted(names, key=lambda n: (first.index(n) if n in first else len(first), n))


def ordered(scenes: Sequence[Scene]) -> tuple[Scene, ...]:
    """Scenes in the order of their systems."""
    places = in_order([*{scene.system for scene in scenes}])
    return tuple(sorted(scenes, key=lambda scene: places.index(scene.system)))


def matrices(study: Study, every: Results, scenes: Sequence[Scene]) -> tuple[Matrix, ...]:
    """A matrix for each kind of system."""
    names = [m.name for engine in engines(study) for m in study.methods if m.engine == engine]
    ran = {pair: of for pair, of in every.items() if of.at_reference}
    tables = []
    for kind in dict.fromkeys(scene.kind for scene in scenes):
        own = [scene.name for scene in scenes if scene.kind == kind]
        shown = tuple(name for name in names if any((scene, name) in ran for scene in own))
        rows = tuple((scene, tuple(ran.get((scene, name)) for name in shown)) for scene in own)
        tables.append(Matrix(kind, shown, rows))
    return tuple(tables)


def engines(study: Study) -> list[str]:
    """The engines of a study in the order of ENGINES, others after them by name."""
    return in_order([*{m.engine for m in study.methods}], list(ENGINES))
