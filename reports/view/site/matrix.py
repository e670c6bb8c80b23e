"""The matrix of results, scenes by methods, and the order of systems and engines in it."""

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
    """The results of all scenes of one kind (rows) by the methods that ran any of them
    (columns)."""

    kind: str
    methods: Sequence[str]
    rows: Sequence[tuple[str, Sequence[MethodResult | None]]]  # scene, one result per method


def rank(name: str, first: Sequence[str] = ORDER) -> tuple[int, str]:
    """Returns a sort key that puts the names in `first` first, in that order, and all other names
    after them, alphabetically."""
    return (first.index(name) if name in first else len(first)), name


def ordered(scenes: Sequence[Scene]) -> Sequence[Scene]:
    """Returns the scenes sorted by their systems, systems in the order of `ORDER`."""
    return sorted(scenes, key=lambda scene: rank(scene.system))


def matrices(study: Study, every: Results, scenes: Sequence[Scene]) -> list[Matrix]:
    """Returns one matrix for each kind of scene among `scenes`. A cell is None if the method has no
    error at the reference step of that scene."""
    order = engines(study)
    methods = sorted(study.methods, key=lambda m: order.index(m.engine))
    ran = {pair: of for pair, of in every.items() if of.at_reference}
    tables = []
    for kind in dict.fromkeys(scene.kind for scene in scenes):
        held = [scene.name for scene in scenes if scene.kind == kind]
        shown = [m.name for m in methods if any((scene, m.name) in ran for scene in held)]
        rows = [(scene, [ran.get((scene, name)) for name in shown]) for scene in held]
        tables.append(Matrix(kind, shown, rows))
    return tables


def engines(study: Study) -> list[str]:
    """Returns the names of the study's engines in the order of `ENGINES`, then all others
    alphabetically."""
    return sorted({m.engine for m in study.methods}, key=lambda name: rank(name, [*ENGINES]))
