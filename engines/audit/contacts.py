"""The contact audit: a user's body slides, turns and is pushed on its plane, under its own friction
settings and under those of `plumbob settings`, compared with Coulomb's law."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.slider_path import fixed
from plumbob.analytic.systems.sliding_body import Stance, stopping_distance
from plumbob.analytic.systems.three_points.friction import InitialVelocities, three_point_motion
from plumbob.engines.audit.moving_joints import FreeSlide, free_slide
from plumbob.engines.own_contacts import ContactModel, SlideToRest, Standing
from plumbob.engines.own_motion import NotCertifiable

SPEED = 0.5  # [m/s]
HEADINGS = tuple(math.radians(d) for d in sorted({*range(0, 360, 30), *range(45, 360, 90)}))
TURN_HEADING = math.radians(30.0)
HALVINGS = 3  # halvings of the model's own step
PUSH = 0.9  # push as a fraction of the friction limit
PUSHED = 1.0  # [s] duration of the push
# Length of a run, as a multiple of the time in which Coulomb friction stops the body
LONGER = 3.0
# Largest ratio of f h to the least distance to the edge of the feet at which loads count as static.
# f is the friction and h the height of the centre of mass.
FLAT = 0.01


@dataclass(frozen=True)
class ContactRun:
    """The distances, drift and turn of the body at one step with one kind of contacts."""

    step: float  # [s]
    distances: Array  # along each heading [m]; NaN if the body does not stop
    turned: float  # [rad] largest turn about the vertical in slides that begin without a turn
    turning: SlideToRest | None  # the slide that begins with a turn
    # [m/s] largest of all headings under the push; None unless `step` is the model's own
    drift: float | None
    tilts: Array  # by heading: displacements by the tilt, in deflections of one contact
    loaded: Array  # by heading: whether every load stays >= 0 as its transient overshoots


@dataclass(frozen=True)
class ContactAudit:
    """The errors of a user model's friction, on its own body, feet and plane."""

    name: str
    standing: Standing
    integrator: str
    step: float  # [s]
    speed: float  # [m/s]
    spin: float  # [rad/s] initial spin of the run that turns
    exact: float | None  # stopping distance [m]; None if Coulomb's law does not determine it
    exact_turn: float | None  # [rad]; None if the theory of three points does not give it
    why: str  # why the distance is not determined
    why_turn: str  # why the turn is not determined
    determined: tuple[bool, ...]  # by heading: whether every load can stay >= 0
    own: tuple[ContactRun, ...]  # coarse to fine; empty if the body does not come to rest
    pasted: tuple[ContactRun, ...]
    failed: tuple[str, ...]  # kinds of contacts that could not be run, with the reason
    snippet: str
    seconds: float
    model: ContactModel
    free: FreeSlide | None = None  # None for a body without joints

    @cached_property
    def distances(self) -> Array:
        """The stopping distances [m] to compare with, by heading: from Coulomb's law, or, if it
        does not determine them, at the finest step on the pasted contacts; NaN if neither is
        known."""
        if self.exact is not None:
            return np.where(self.determined, self.exact, np.nan)
        if not self.pasted:
            return np.full(len(HEADINGS), np.nan)
        return self.pasted[-1].distances

    @cached_property
    def known(self) -> float:
        """The uncertainty [m] of these distances: 0 from Coulomb's law, else the largest difference
        between the two finest steps."""
        if self.exact is not None or len(self.pasted) < 2:
            return 0.0 if self.exact is not None else math.inf
        differences = np.abs(self.pasted[-1].distances - self.pasted[-2].distances)
        return math.inf if np.isnan(differences).all() else float(np.nanmax(differences))

    def errors(self, run: ContactRun) -> Array:
        """Returns the errors of stopping distances [m], by heading; infinite if the body does not
        stop."""
        differences = run.distances - self.distances
        return np.where(
            np.isnan(run.distances) & ~np.isnan(self.distances), np.inf, differences
        )

    def error(self, run: ContactRun) -> float:
        """Returns the largest error of a stopping distance [m]; NaN if none is known."""
        errors = np.abs(self.errors(run))
        return float(np.nanmax(errors)) if not np.isnan(errors).all() else math.nan

    def dependence(self, run: ContactRun) -> float:
        """Returns the largest less the smallest stopping distance over their mean, for the headings
        at which the distance is determined; NaN if the body does not stop."""
        distances = run.distances[list(self.determined)]
        return (
            float((distances.max() - distances.min()) / distances.mean())
            if distances.size
            else math.nan
        )

    def predicted(self, run: ContactRun) -> Array | None:
        """Returns the predicted errors of stopping distances on the pasted contacts [m], by
        heading; None if the distance is not determined. One part is of first order in the step. The
        other part is from the tilt by the deflection of contacts, which is linear as long as every
        load is positive; if a load reaches 0, the prediction is NaN."""
        first_order = self.model.first_order
        if self.exact is None or first_order is None:
            return None
        friction = self.standing.coefficient * self.standing.gravity
        tilt = friction * run.tilts * (run.step / self.model.stiffness) ** 2
        error = first_order * self.speed * run.step / self.step - tilt
        return np.where(run.loaded, error, np.nan)

    def assert_within(self, metres: float) -> None:
        """Raises AssertionError unless the model's own stopping distances are known and within
        `metres` at every heading."""
        __tracebackhide__ = True
        worst = self.error(self.own[0]) + self.known if self.own else math.nan
        if math.isnan(worst):
            reason = "; ".join(filter(None, (self.why, *self.failed)))
            raise AssertionError(f"{self.name}: no stopping distance to compare with: {reason}")
        if not worst <= metres:
            raise AssertionError(
                f"{self.name}: the stopping distance at {self.speed:g} m/s is {worst:.3g} m off, "
                f"more than {metres:g} m"
            )


def contacts_audited(model: ContactModel, speed: float = SPEED) -> ContactAudit:
    """Returns the contact audit of `model` at `speed` [m/s]. Raises NotCertifiable if the body does
    not stand."""
    begin = time.perf_counter()
    standing = model.standing
    stance = Stance(standing.points, standing.height)
    margin = stance.inside(np.zeros(2))
    if not margin > 0.0:
        raise NotCertifiable(
            f"{standing.body} rests on fewer than three points that are not on one line "
            f"({', '.join(standing.feet)}): it tips or rolls"
        )
    spin = speed / float(np.hypot(*standing.points.T).mean())
    determined = tuple(stance.slides(max(standing.friction), h) for h in HEADINGS)
    why = why_distance_undetermined(standing, determined)
    why_turn = why or why_turn_undetermined(standing, margin)
    exact = None if why else stopping_distance(speed, standing.coefficient, standing.gravity)
    exact_turn = None if why_turn else theoretical_turn(standing, speed, spin)
    as_written, why_not = _slides_at_halved_steps(model, "own", speed, spin)
    as_pasted, why_not_pasted = _slides_at_halved_steps(model, "pasted", speed, spin)
    return ContactAudit(
        name=model.name,
        standing=standing,
        integrator=model.integrator,
        step=model.step,
        speed=speed,
        spin=spin,
        exact=exact,
        exact_turn=exact_turn,
        why=why,
        why_turn=why_turn,
        determined=determined,
        own=as_written,
        pasted=as_pasted,
        failed=(*why_not, *why_not_pasted),
        snippet=model.snippet(),
        model=model,
        free=free_slide(model, speed, _run_length(standing, speed))
        if standing.locked
        else None,
        seconds=time.perf_counter() - begin,
    )


def _slides_at_halved_steps(
    model: ContactModel, kind: str, speed: float, spin: float
) -> tuple[tuple[ContactRun, ...], tuple[str, ...]]:
    """Returns the slides on contacts of a `kind` at the model's step and its halvings, and the
    reason if they end early. At the step itself the body is also pushed along headings at which it
    does not tip."""
    standing = model.standing
    runs = list[ContactRun]()
    duration = _run_length(standing, speed)
    largest_friction = max(standing.friction)
    push = PUSH * float(np.mean(standing.friction)) * standing.gravity
    upright = Stance(standing.points, standing.height)
    for halvings in range(HALVINGS + 1):
        step = model.step / 2**halvings
        try:
            floor = getattr(model, kind)(step)
            differing = set(floor.feet) ^ set(standing.feet)
            if differing:
                raise NotCertifiable(
                    f"at {step:g} s other geoms touch ({', '.join(sorted(differing))})"
                )
        except NotCertifiable as reason:
            return tuple(runs), (f"{kind} contacts: {reason}",)
        stance = Stance(floor.points[:, :2], -float(floor.points[:, 2].mean()))
        pushed = [
            heading
            for heading in HEADINGS[::2]
            if not halvings and upright.slides(PUSH * largest_friction, heading)
        ]
        slides = [floor.slide(heading, speed, 0.0, duration) for heading in HEADINGS]
        runs.append(
            ContactRun(
                step,
                np.array([s.along if s.rests else np.nan for s in slides]),
                max(abs(s.turn) for s in slides),
                floor.slide(TURN_HEADING, speed, spin, LONGER * duration),
                max((floor.drift(heading, push, PUSHED) for heading in pushed), default=None),
                np.array([stance.tilt(heading) for heading in HEADINGS]),
                np.array(
                    [
                        stance.slides(model.overshoot * largest_friction, heading)
                        for heading in HEADINGS
                    ]
                ),
            )
        )
    return tuple(runs), ()


def _run_length(standing: Standing, speed: float) -> float:
    """Returns the length [s] of a run: LONGER times the time in which Coulomb friction stops the
    body."""
    return LONGER * speed / (min(standing.friction) * standing.gravity)


def why_distance_undetermined(standing: Standing, determined: tuple[bool, ...]) -> str:
    """Explains why Coulomb's law does not determine the stopping distance; empty if it does."""
    if math.isnan(standing.coefficient):
        least = min(standing.friction)
        most = max(standing.friction)
        return f"feet have different friction coefficients ({least:g} … {most:g})"
    if not any(determined):
        return (
            f"it tips, as its centre of mass, {standing.height:.3g} m above the plane, is too high "
            f"for friction {max(standing.friction):g}"
        )
    return ""


def why_turn_undetermined(standing: Standing, margin: float) -> str:
    """Explains why the theory of three points does not give the turn; empty if it does. `margin`
    is the least distance [m] of the centre of mass to the edge of the feet."""
    if standing.torsion:
        return "contacts resist turns by moments of their own (condim above 3)"
    if len(standing.points) != 3:
        share = f"{len(standing.points)} points share the load as their stiffness decides"
        return f"{share}, which Coulomb's law leaves open"
    if standing.coefficient * standing.height > FLAT * margin:
        return (
            f"the centre of mass is {standing.height:.3g} m high, so loads change with the slip, "
            "for which there is no closed form"
        )
    return ""


def theoretical_turn(standing: Standing, speed: float, spin: float) -> float:
    """Returns the turn [rad] of a flat body on three points that begins at `speed` [m/s] and `spin`
    [rad/s], by the theory of three points."""
    first, second, third = ((float(p[0]), float(p[1])) for p in standing.points)
    # Half of the mass is at the centre of mass, as the body is no point mass
    half_mass = standing.mass / 2
    body = Capsule(
        half_mass,
        half_mass,
        standing.inertia,
        (first, second, third),
        standing.coefficient,
        standing.gravity,
    )
    velocity = (speed * math.cos(TURN_HEADING), speed * math.sin(TURN_HEADING))
    motion = three_point_motion(
        body, fixed((0.0, 0.0)), InitialVelocities(velocity=velocity, angular_velocity=spin)
    )
    return float(motion.at(np.array([motion.rest_time])).heading[0])
