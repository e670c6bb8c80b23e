"""The audit of what holds: whether Coulomb friction holds a user's bodies at rest, how fast the
engine lets them creep, and which options stop that."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from plumbob.engines.own_holds import (
    FrictionOptions,
    HeldGroup,
    HeldModel,
    MeasuredCreep,
    RestingPlace,
)

if TYPE_CHECKING:  # its functions load scipy, which no other audit needs at its begin
    from plumbob.analytic.systems.coulomb_statics import Statics

Coulomb = Literal["holds", "can hold with a preload", "too close to tell", "cannot hold"]
VERDICTS: tuple[Coulomb, ...] = (
    "holds",
    "can hold with a preload",
    "too close to tell",
    "cannot hold",
)
SHORT_CREEP, LONG_CREEP = 1.0, 60.0  # [s] durations over which bodies creep
NEAR = 0.2  # relative error of a predicted creep within which it counts as explained
# Ratio of a displacement to that of a steady creep at which bodies have lost their contacts
LEFT = 3.0
CREEP_WANTED = 1e-5  # [m/s] largest creep that is asked for by default: 0.6 mm in a minute


@dataclass(frozen=True)
class GroupVerdict:
    """The verdict of Coulomb's law on bodies that joints and contacts connect."""

    group: HeldGroup
    coulomb: Coulomb
    statics: Statics


@dataclass(frozen=True)
class CreepRemedy:
    """Options that are tried against creep, and what they change."""

    options: FrictionOptions
    creep: MeasuredCreep
    cost: float  # ratio of a step's processor time to the time with the model's own options
    refusal: str  # reason why the audit of a motion refuses the options; empty if it does not

    def stops(self, wanted: float) -> bool:
        """Returns whether the bodies creep at most at a speed [m/s]."""
        return self.creep.speed <= wanted


@dataclass(frozen=True)
class HoldsAudit:
    """The verdicts of Coulomb's law on a user's bodies at rest, and their creep in the engine."""

    name: str
    integrator: str
    step: float  # [s]
    model: HeldModel
    at_start: bool  # whether the bodies are judged at the start; else where they have settled
    moved: float  # [m] displacement from the start to where they are judged
    groups: tuple[GroupVerdict, ...]
    predicted: float | None  # [m/s] creep; None if friction does not hold the bodies
    creep: MeasuredCreep
    wanted: float  # [m/s] largest creep that is asked for
    tried: tuple[CreepRemedy, ...]
    seconds: float  # wall time

    @property
    def worst(self) -> GroupVerdict:
        """The group with the worst verdict, and of these the one with the smallest margin."""
        return max(
            self.groups,
            key=lambda g: (VERDICTS.index(g.coulomb), g.statics.least_friction),
        )

    @property
    def coulomb(self) -> Coulomb:
        """The worst verdict of all bodies."""
        return self.worst.coulomb

    @property
    def most_friction(self) -> float:
        """The largest multiple of the friction that is tried."""
        from plumbob.analytic.systems.coulomb_statics import MOST_FRICTION

        return MOST_FRICTION

    @property
    def as_predicted(self) -> bool:
        """Whether the measured creep is near the predicted one, or both are within what is asked
        for. If contacts vibrate or change, the theory of a steady creep does not apply."""
        if self.predicted is None:
            return False
        speeds = self.predicted, self.creep.speed
        return max(speeds) <= self.wanted or abs(speeds[0] - speeds[1]) <= NEAR * speeds[1]

    @property
    def leaves(self) -> bool:
        """Whether the bodies move much further in a minute than they creep."""
        far = self.creep.distances.get(LONG_CREEP, 0.0)
        return far > LEFT * LONG_CREEP * self.creep.speed

    @property
    def remedy(self) -> CreepRemedy | None:
        """The first options that were tried and stop the creep; None if none do."""
        return next((r for r in self.tried if r.stops(self.wanted)), None)

    def assert_holds(self) -> None:
        """Raises AssertionError if Coulomb's law cannot hold the bodies."""
        if self.coulomb == "cannot hold":
            bodies = ", ".join(self.worst.group.bodies)
            raise AssertionError(f"{self.name}: friction cannot hold {bodies}")

    def assert_creeps_within(self, speed: float) -> None:
        """Raises AssertionError if the bodies creep faster than a `speed` [m/s]."""
        if not self.creep.speed <= speed:
            raise AssertionError(
                f"{self.name}: creeps at {self.creep.speed:.3g} m/s, more than {speed:g} m/s"
            )


def group_verdict(group: HeldGroup) -> GroupVerdict:
    """Returns what Coulomb's law says about a group of bodies."""
    from plumbob.analytic.systems.coulomb_statics import contact_statics
    from plumbob.analytic.systems.first_motion import can_move

    known = contact_statics(group.loads)
    if known.close:
        return GroupVerdict(group, "too close to tell", known)
    if not known.balanced:
        return GroupVerdict(group, "cannot hold", known)
    coulomb: dict[bool | None, Coulomb] = {
        False: "holds",
        True: "can hold with a preload",
        None: "too close to tell",
    }
    return GroupVerdict(group, coulomb[can_move(group.loads)], known)


def _judged(place: RestingPlace | None) -> tuple[GroupVerdict, ...]:
    """Returns the verdicts on the groups of bodies in a place."""
    return tuple(map(group_verdict, place.groups)) if place else ()


def _can_hold(verdicts: Sequence[GroupVerdict]) -> bool:
    """Returns whether there are bodies, and none that friction cannot hold."""
    return bool(verdicts) and all(v.coulomb != "cannot hold" for v in verdicts)


def holds_audited(
    model: HeldModel,
    wanted: float,
    advised: Callable[[FrictionOptions, float | None, float], Sequence[FrictionOptions]],
) -> HoldsAudit:
    """Returns the audit of the bodies of `model`, with options that bring the creep to `wanted`
    [m/s]. `advised` returns the options to try, from the model's own, the creep [m/s] that is
    predicted for elliptic cones with impratio 1, and `wanted`."""
    begin = time.perf_counter()
    place, verdicts = model.at_start, _judged(model.at_start)
    at_start = True
    if not _can_hold(verdicts):
        # Springs and servos carry loads only after they have given way.
        settled = _judged(model.settled)
        if model.settled is not None and (_can_hold(settled) or not verdicts):
            place, verdicts, at_start = model.settled, settled, False
    audit = HoldsAudit(
        name=model.name,
        integrator=model.integrator,
        step=model.step,
        model=model,
        at_start=at_start,
        moved=place.moved,
        groups=verdicts,
        predicted=model.predicted_creep() if _can_hold(verdicts) else None,
        creep=model.creep((SHORT_CREEP, LONG_CREEP)),
        wanted=wanted,
        tried=(),
        seconds=0.0,
    )
    if audit.coulomb != "cannot hold" and not audit.creep.speed <= wanted:
        audit = replace(audit, tried=_remedies(audit, advised))
    return replace(audit, seconds=time.perf_counter() - begin)


def _remedies(
    audit: HoldsAudit,
    advised: Callable[[FrictionOptions, float | None, float], Sequence[FrictionOptions]],
) -> tuple[CreepRemedy, ...]:
    """Returns the options that were tried, up to the first that stop the creep."""
    model, wanted = audit.model, audit.wanted
    rigid = model.with_options(FrictionOptions("elliptic", 1.0)).predicted_creep()
    tried = list[CreepRemedy]()
    for options in advised(model.options, rigid, wanted):
        changed = model.with_options(options)
        creep = changed.creep((SHORT_CREEP,))
        cost = creep.step_seconds / (audit.creep.step_seconds or math.nan)
        tried.append(CreepRemedy(options, creep, cost, changed.refusal))
        if creep.speed <= wanted:
            break
    return tuple(tried)
