"""The terms of an engine's equations of motion compared with those of a user's model, in states
along its certified motion: which differ, and why."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import ModelFields, ModelReader
from plumbob.engines.audit.reference import largest_distances
from plumbob.engines.method import Engine
from plumbob.engines.own_motion import OwnModel, Script
from plumbob.engines.peer_model import PeerModel, Terms
from plumbob.engines.registry import find_engine
from plumbob.engines.study.model_reading import dropped, fields_of

# Terms in the order of their comparison: each may make later terms differ.
TERMS = ("mass matrix", "gravity", "bias", "passive", "actuator")
CONTACTS, AXES = "contact set", "friction axes"
STEP, SINGLE, INTEGRATOR = "acceleration", "single precision", "integrator"
# Largest relative difference of terms that count as the same: single precision and new frames cause
# less
SAME = 1e-5
# Roundings of the sum of all forces that count as the same in one force: forces cancel
ROUNDINGS = 100.0
# Largest relative difference of accelerations in a step that count as the same: schemes of first
# order cause less.
SAME_STEP = 0.02
TURNED = 1e-3  # [rad] largest turn of axes that count as the same: single precision causes less
# Fields of a file on which a term depends.
DEPENDS = MappingProxyType(
    {
        "mass matrix": ("mass", "inertia", "armature"),
        "gravity": ("gravity", "mass"),
        "bias": ("mass", "inertia"),
        "passive": ("stiffness", "damping"),
        "actuator": ("gear", "kp", "kv"),
    }
)
NAMELESS = frozenset(["a body without a name"])
SAMPLES = 9  # states along the certified motion
Readings = tuple[ModelFields, ModelFields]
"""The numbers of a file as MuJoCo reads them, and as an engine reads them."""


@dataclass(frozen=True)
class ReferenceMotion:
    """The certified motion with which engines are compared."""

    file: Path
    model: OwnModel
    script: Script  # controls up to the time to which the motion is certified
    states: Array  # certified, shape (periods + 1, ...)
    seconds: float  # [s] processor time for one run

    @property
    def parts(self) -> int:
        """The number of steps in a control period."""
        return self.script.parts(self.model.step)

    def errors(self, states: Array) -> Array:
        """Returns the largest errors so far [m] of states at the ends of the periods."""
        return largest_distances(self.model.corners(states), self.model.corners(self.states))


@dataclass(frozen=True)
class TermDifference:
    """A term of an engine's equations that differs from the file's term."""

    term: str
    size: float  # relative difference, largest along the motion
    cause: str = ""  # cause of the difference; empty if it is not known


@dataclass(frozen=True)
class Look:
    """The terms of the file and the terms of an engine in one state."""

    state: Array
    control: Array
    of_file: Terms
    of_engine: Terms
    accelerations: tuple[Array, Array, Array]
    """In the first step from the state: in MuJoCo by the file's integrator, in MuJoCo by the
    engine's integrator, and in the engine."""

    def size(self, difference: Array) -> float:
        """Returns the size of generalised forces f, the root of f' M^-1 f, which is the same in all
        coordinates; of mass matrices, the largest element relative to the diagonal."""
        inertia = self.of_file[TERMS[0]]
        if difference.ndim == 1:
            return float(np.sqrt(difference @ np.linalg.solve(inertia, difference)))
        scale = np.sqrt(np.diag(inertia))
        return float(np.max(np.abs(difference) / np.outer(scale, scale), initial=0.0))


def look_at_states(peer: PeerModel, motion: ReferenceMotion) -> list[Look]:
    """Returns looks at some states along the certified motion: at the ends of periods, and where
    something touches."""
    terms = motion.model.terms()
    controls = motion.script.controls
    samples = [(k, motion.states[k]) for k in _spread_indices(len(controls))]
    touching = list(motion.model.touched(motion.script))
    samples += [touching[k] for k in _spread_indices(len(touching))]
    looks = []
    for k, state in samples:
        control = controls[k]
        engine_terms = peer.terms(state, control)
        accelerations = _accelerations(peer, motion, state, control)
        looks.append(Look(state, control, terms(state, control), engine_terms, accelerations))
    return looks


def _accelerations(
    peer: PeerModel, motion: ReferenceMotion, state: Array, control: Array
) -> tuple[Array, Array, Array]:
    """Returns the accelerations in a step from a state, as `Look` has them."""
    velocity = motion.model.layout.velocity
    one_step = Script(state, motion.model.step, control[None])
    peer.begin(state)
    by_own, by_scheme = (
        motion.model.stepped(one_step, integrator, 1).states[1]
        for integrator in (motion.model.integrator, peer.integrator)
    )
    after = by_own, by_scheme, peer.advance(control, 0.0 * state[velocity], 1)
    by_own, by_scheme, by_engine = (
        (end[velocity] - state[velocity]) / motion.model.step for end in after
    )
    return by_own, by_scheme, by_engine


def _spread_indices(count: int) -> list[int]:
    """Returns evenly spread indices, at most SAMPLES of `count`."""
    return sorted(set(np.linspace(0, count - 1, min(count, SAMPLES)).astype(int).tolist()))


def term_differences(
    engine: Engine,
    looks: Sequence[Look],
    motion: ReferenceMotion,
    precision: float,
    integrators: tuple[str, str],
) -> list[TermDifference]:
    """Returns the terms of the equation of motion that differ between the file, as MuJoCo reads
    it, and the engine, in the order of TERMS. If no term differs, returns the differences of steps;
    `integrators` are those of `step_differences`. `looks` are the terms at some states."""
    overall = (
        ROUNDINGS * precision * max(look.size(total_force(look.of_file)) for look in looks)
    )
    differing = list[TermDifference]()
    readings = readings_of(engine, motion.file)
    for term in TERMS:
        pairs = [(look, look.of_file[term], look.of_engine[term]) for look in looks]
        difference = max(look.size(of_engine - of_file) for look, of_file, of_engine in pairs)
        scale = max(
            max(look.size(of_file), look.size(of_engine)) for look, of_file, of_engine in pairs
        )
        if not difference <= SAME * scale + (0.0 if term == TERMS[0] else overall):
            differing.append(
                TermDifference(term, difference / scale, _cause(term, looks, readings))
            )
    differing += [*_contact_differences(looks, motion), *_axis_differences(looks, motion)]
    return differing or list(step_differences(looks, integrators))


def _contact_differences(
    looks: Sequence[Look], motion: ReferenceMotion
) -> Iterator[TermDifference]:
    """Yields the difference of the pairs of bodies that touch in some state in only one of the file
    and the engine."""
    in_file = set[frozenset[str]]()
    in_engine = set[frozenset[str]]()
    for look in looks:
        in_file |= {_moving_bodies(pair, motion) for pair in look.of_file["contacts"]}
        in_engine |= {_moving_bodies(pair, motion) for pair in look.of_engine["contacts"]}
    if in_file != in_engine:
        parts = ((in_file - in_engine, "missing"), (in_engine - in_file, "more"))
        cause = (f"{kind}: {_names_of_pairs(pairs)}" for pairs, kind in parts if pairs)
        size = len(in_file ^ in_engine) / len(in_file | in_engine)
        yield TermDifference(CONTACTS, size, "; ".join(cause))


def _axis_differences(
    looks: Sequence[Look], motion: ReferenceMotion
) -> Iterator[TermDifference]:
    """Yields the largest angle about the normal between a contact's friction pyramid in the file
    and in the engine. A pyramid has four edges, so that angles repeat after a quarter turn."""
    angles = dict[frozenset[str], float]()
    for look in looks:
        file_axes, engine_axes = (
            {_moving_bodies(pair, motion): axis for pair, axis in terms.get("axes", ())}
            for terms in (look.of_file, look.of_engine)
        )
        for pair in file_axes.keys() & engine_axes.keys():
            angle = math.acos(min(1.0, abs(float(file_axes[pair] @ engine_axes[pair]))))
            angles[pair] = max(angles.get(pair, 0.0), min(angle, 0.5 * math.pi - angle))
    largest_angle = max(angles.values(), default=0.0)
    if largest_angle > TURNED:
        pairs = _names_of_pairs([pair for pair in angles if angles[pair] > TURNED])
        degrees = f"{math.degrees(largest_angle):.0f}°"
        cause = f"the pyramid of friction is turned by up to {degrees}: {pairs}"
        yield TermDifference(
            AXES, largest_angle / (0.25 * math.pi), f"{cause}; an elliptic cone has no axes"
        )


def step_differences(
    looks: Sequence[Look], integrators: tuple[str, str]
) -> Iterator[TermDifference]:
    """Yields the differences of the acceleration in a step, if all terms are alike. One part comes
    from the `integrators` of the file and of the engine, the rest from constraints."""
    size, _ = _acceleration_difference(looks, 0, 1)
    if size > SAME_STEP:
        file_integrator, engine_integrator = integrators
        cause = (
            f"it steps {engine_integrator}, the file {file_integrator}: {size:.2g} of the "
            "acceleration in a step"
        )
        yield TermDifference(INTEGRATOR, size, cause)
    size, look = _acceleration_difference(looks, 1, 2)
    if size > SAME_STEP:
        kinds = [*look.of_file["acting"], *["contacts"] * bool(look.of_file["contacts"])]
        stated: str = look.of_engine.get("causes", {}).get(STEP, "")
        yield TermDifference(STEP, size, " and ".join(kinds) or stated)


def _acceleration_difference(
    looks: Sequence[Look], first: int, second: int
) -> tuple[float, Look]:
    """Returns the largest difference of the accelerations number `first` and `second` in a step,
    relative to the largest of the first, and the look with that difference."""
    forces = [[look.of_file[TERMS[0]] @ a for a in look.accelerations] for look in looks]
    sizes = [
        look.size(force[second] - force[first])
        for look, force in zip(looks, forces, strict=True)
    ]
    scale = max(look.size(force[first]) for look, force in zip(looks, forces, strict=True))
    return max(sizes) / scale if max(sizes) else 0.0, looks[int(np.argmax(sizes))]


def _names_of_pairs(pairs: Iterable[frozenset[str]]) -> str:
    """Names the first pair of bodies that touch, and the number of the other pairs."""
    first, *more = sorted(" – ".join(sorted(pair)) for pair in pairs)
    return f"{first} and {len(more)} more" if more else first


def _moving_bodies(pair: tuple[str, ...], motion: ReferenceMotion) -> frozenset[str]:
    """Returns the moving bodies of a pair that touches. A single body touches something that does
    not move."""
    return frozenset(pair) & set(motion.model.layout.bodies) or NAMELESS


def total_force(terms: Terms) -> Array:
    """Returns the sum of all generalised forces except those of constraints."""
    total: Array = terms["gravity"] - terms["bias"] + terms["passive"] + terms["actuator"]
    return total


def _cause(term: str, looks: Sequence[Look], readings: Readings) -> str:
    """Explains why a term differs. The engine may state a cause; the term may be missing; or the
    engine may read a field on which the term depends differently."""
    stated: str = looks[0].of_engine.get("causes", {}).get(term, "")
    if stated or (term != "gravity" and not any(look.of_engine[term].any() for look in looks)):
        return stated or "all of it dropped"
    of_file, of_engine = readings
    misread = dropped(of_file, of_engine)
    masses = [
        of_engine[key][0] / of_file[key][0]
        for key in of_file
        if key[0] == "mass" and key in of_engine
    ]
    if "mass" in misread and len(masses) > 1 and np.ptp(masses) < SAME * masses[0]:
        misread["mass"] = f"times {masses[0]:.4g}, all of them"
    for field in DEPENDS.get(term, ()):
        if field in misread:
            return f"{field} {misread[field] or 'dropped'}"
    return "of like bodies: joints or frames are not alike" if term == TERMS[0] else ""


def readings_of(engine: Engine, file: Path) -> Readings:
    """Returns the numbers of a file as MuJoCo reads them, and as an engine reads them."""
    of_mujoco = fields_of(find_engine("mujoco"), file)[1]
    return of_mujoco, of_mujoco if engine.ability(ModelReader) is None else fields_of(
        engine, file
    )[1]
