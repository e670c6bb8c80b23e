"""Observables that no tolerance applies to, with their reasons: strict, so that a verdict is
unexpected where an engine drops an observable, theory does not cover one, or a reason no longer
holds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import find_engine
from plumbob.models.registry import find_system
from plumbob.reports.judge.known_limits import fits


@dataclass(frozen=True)
class Unjudged:
    """Observables that scenes and methods of these patterns leave out, or are not judged by."""

    scenes: str
    methods: str
    observables: tuple[str, ...]
    reason: str
    left_out: bool = False  # the engine gives none; else theory says nothing of its error


_LINE = "the model is a body on a line, without heading, and without feet that differ"
_SIDE = "the model is seen from the side: nothing in it leaves the line"
_ABOVE = "the model is seen from above: normal forces are those of statics, given to it"
_NO_ROD = "the equation of motion is one of the angle: no rod pulls in it"
_NOT_READ = "the reaction of a hinge is not read off this engine"
_NO_FORCES = "contact forces are impulses of a step here, and are not read off"
_PEERS = ("dart/*", "drake/*", "exudyn/*", "mjx/*", "pinocchio/*", "pybullet/*")
_FORCES = ("friction_force", "driving_force")
_REDUCED = ("mujoco/euler+reduced", "mujoco/rk4+reduced")
_FEET = ("normal_force_1", "normal_force_2", "normal_force_3")
_ON_LINES = ("capsule-hold/*", "capsule-line/*", "capsule-train/*")

DECLARED: tuple[Unjudged, ...] = (
    *(
        Unjudged(s, m, ("heading", "sideways", *_FEET), _LINE, left_out=True)
        for s in _ON_LINES
        for m in _REDUCED
    ),
    *(
        Unjudged("capsule-coast/*", m, ("heading", "heading_rate", *_FEET), _LINE, left_out=True)
        for m in _REDUCED
    ),
    *(Unjudged(s, "pymunk/side", ("heading", "sideways"), _SIDE, left_out=True) for s in _ON_LINES),
    Unjudged(
        "capsule-coast/*", "pymunk/side", ("heading", "heading_rate", *_FEET), _SIDE, left_out=True
    ),
    *(
        Unjudged(s, m, _FEET, _ABOVE, left_out=True)
        for s in ("capsule-coast/*", "capsule-turn/*", "capsule-plan/*")
        for m in ("pymunk/feet", "pymunk/pivots")
    ),
    *(
        Unjudged("simple-pendulum/*", m, ("tension",), _NO_ROD, left_out=True)
        for m in ("ode/*", "heyoka/*")
    ),
    *(Unjudged("simple-pendulum/*", m, ("tension",), _NOT_READ, left_out=True) for m in _PEERS),
    *(
        Unjudged(s, m, (*_FEET, *_FORCES), _NO_FORCES, left_out=True)
        for s in _ON_LINES
        for m in _PEERS
    ),
    *(
        Unjudged(s, m, _FEET, _NO_FORCES, left_out=True)
        for s in ("capsule-coast/*", "capsule-turn/*", "capsule-plan/*")
        for m in _PEERS
    ),
)


def declared(scene: str, method: str) -> Mapping[str, Unjudged]:
    """The observables of a scene and method that are declared unjudged, each with its first
    declaration."""
    reasons = _not_read(scene, method)
    for entry in DECLARED:
        if fits(scene, entry.scenes) and fits(method, entry.methods):
            reasons = {name: entry for name in entry.observables} | reasons
    return reasons


def _not_read(scene: str, method: str) -> dict[str, Unjudged]:
    """The observables of a scene that the method's engine says it gives of none."""
    try:
        engine = find_engine(method.partition("/")[0])
    except ParameterError:  # of a stored study, whose engine is no longer there
        return {}
    if not engine.not_read:
        return {}
    names = [o.name for o in find_system(scene.partition("/")[0]).observables]
    return {
        name: Unjudged(scene, method, (name,), why, left_out=True)
        for name, why in engine.not_read.items()
        if name in names
    }


def undeclared(scene: str, method: str, names: Iterable[str], left_out: bool) -> tuple[str, ...]:
    """Those of the observables `names`, left out or not judged, that are not declared so."""
    known = declared(scene, method)
    return tuple(n for n in names if n not in known or known[n].left_out != left_out)
