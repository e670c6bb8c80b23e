"""The simple pendulum's cases, and what a study measured of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

from plumbob.analytic.reference import Reference
from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import ConvergenceStudy, convergence_study
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.order import Order
from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import MOST_STEPS
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.models.scene import Scene
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell

SIMPLE, LINEAR = "simple-pendulum/", "linear-pendulum/"
CASES: Sequence[tuple[str, str, str]] = (
    ("1", "free-small", "θ₀ = –10°, from rest"),
    ("2", "free-large", "θ₀ = –120°, from rest"),
    ("3", "rotating-slow", "θ₀ = –120°, at 200°/s"),
    ("4", "rotating-fast", "θ₀ = –120°, at 500°/s"),
    ("5", "damped-small", "θ₀ = –10°, ξ = 0.08/s"),
    ("6", "damped-large", "θ₀ = –120°, ξ = 0.08/s"),
    ("7", "damped-rotating", "θ₀ = –120°, at 500°/s, ξ = 0.2/s"),
)
FORCED = ("forced-small", "forced-large", "forced-chaotic")


@dataclass(frozen=True)
class Case:
    """A scene with its problem and its exact motion, which takes a tenth of a second."""

    scene: Scene
    problem: SimplePendulum
    exact: Reference


@cache
def case(name: str) -> Case:
    """A scene by its name, its problem and its exact motion."""
    scene = find_scene(name)
    system = system_of(scene)
    problem: SimplePendulum = system.problem(scene.parameters)
    return Case(scene, problem, system.reference(problem))


def convergence(study: Study) -> Mapping[tuple[str, str], ConvergenceStudy]:
    """The study's convergence, by scene and method."""
    return {(c.scene, c.method): c for c in study.convergence}


def measured(study: Study, scene: str, method: str, step: float) -> Measurement | None:
    """What the study measured of a scene with a method at a step [s]; None where it did not."""
    found = convergence(study).get((scene, method))
    runs = found.measurements if found else ()
    return next((m for m in runs if m.step == step and m.status == "done"), None)


def refined(
    study: Study, scene: str, method: str, steps: tuple[float, ...], duration: float
) -> ConvergenceStudy | None:
    """The study's convergence_study of a scene with a method, or else one of its own over `steps` [s] and
    `duration` [s]; None where the engine is missing."""
    if (found := convergence(study).get((scene, method))) is not None and found.order is not None:
        return found
    how = find_method(method)
    if not installed(engine_of(how)):
        return None
    return convergence_study(
        replace(find_scene(scene), duration=duration), how, MOST_STEPS["quick"], steps
    )


def order_text(order: Order | None) -> str:
    """An order with its confidence interval."""
    return f"{order.slope:.3f} [{order.low:.3f}, {order.high:.3f}]" if order else "–"


def number(value: float | None, digits: int = 3) -> Cell:
    """A cell with a number; a dash where there is none."""
    return Cell("–" if value is None else notation.number(value, digits), "number")
