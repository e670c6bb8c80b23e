"""Derivatives from event to event against differences of whole motions at the same part of each
phase; and that a saltation with a term left out is noticed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from plumbob.analytic.reference import Array
from plumbob.analytic.sensitivities import sliding_motion
from plumbob.analytic.sensitivities.capsule import phased
from plumbob.analytic.sensitivities.neighbours import CENTRAL, Neighbours, Sensitivity
from plumbob.analytic.sensitivities.phases import phased_gradients
from plumbob.models.gradient import exact_gradient
from plumbob.models.registry import case_of, scene
from plumbob.models.scene import Case
from plumbob.tests.support.derivatives import scaled

ACCURATE = 1e-7  # of scale


def through_events(
    case: Case, names: Sequence[str], step: float = 3e-4
) -> tuple[Array, dict[str, Sensitivity]]:
    """Times in every phase of a motion from event to event, near the ends of each too, and its
    derivatives by differences of whole motions at the same part of each phase."""
    switches = np.append(phased(case.problem).switches, case.scene.duration)
    low, high = switches[:-1], switches[1:]
    times = np.unique(np.concatenate([low + part * (high - low) for part in (0.1, 0.5, 0.9)]))
    found = {}
    for name in names:
        number = case.scene.parameters[name]
        values = [number + k * step * (abs(number) or 1.0) for k in CENTRAL]
        changes = ({**case.scene.parameters, name: value} for value in values)
        problems = tuple(case.system.problem(changed) for changed in changes)
        beside = Neighbours(problems, np.array(values) - number)
        found[name] = phased_gradients([beside.each(phased)], times)[0]
    return times, found


EVENTFUL = (
    ("capsule-coast/spin", ("friction", "velocity_x", "heading_rate", "inertia", "slider_mass")),
    ("capsule-turn/pivot", ("friction", "radius", "half_time", "start", "inertia")),
    ("capsule-turn/held", ("friction", "radius", "half_time", "angular_acceleration")),
    ("capsule-turn/0.1", ("friction", "radius", "body_mass", "start", "gravity")),
)


def differing(case: Case, names: Sequence[str]) -> list[str]:
    """What differs from the differences of whole motions by more than these are uncertain."""
    times, differences = through_events(case, names)
    found, observed = exact_gradient(case, names, times), case.reference.observe(times)
    wrong = []
    for name, other in differences.items():
        for observable, values in found[name].values.items():
            number = case.scene.parameters[name]
            scale = scaled(values, observed[observable], number)
            off = np.abs(values - other.values[observable])
            unsure = found[name].uncertainty[observable]
            allowed = ACCURATE * scale + 4 * other.uncertainty[observable]
            if not (off <= allowed).all() or not (unsure <= ACCURATE * scale).all():
                wrong.append(f"{name} {observable} {off.max() / scale} {unsure.max() / scale}")
    return wrong


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(("name", "by"), EVENTFUL, ids=[name for name, _ in EVENTFUL])
def test_derivatives_through_events(name: str, by: tuple[str, ...]) -> None:
    """Slides, pivots, stops and slips, with saltation at each, in all phases."""
    assert not differing(case_of(scene(name)), by)


SABOTAGE = ("before", "after", "delay of a stop", "delay of a piece")


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("term", SABOTAGE)
def test_saltation_needs_every_term(term: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """F-, F+, and the delay of an event by a stop and by the slider's path: each is missed."""
    nothing = np.zeros(6)
    if term == "before":
        monkeypatch.setattr(sliding_motion, "_before", lambda *_: nothing + 1e-30)
    elif term == "after":
        monkeypatch.setattr(sliding_motion, "_after", lambda *_: nothing)
    elif term == "delay of a stop":
        still = np.zeros(2)
        monkeypatch.setattr(sliding_motion, "_stop_delays", lambda *_: still)
    else:
        path = sliding_motion._delays

        def kept(before: Any, after: Any, columns: Array, *rest: Any) -> Array:
            if before.segment.piece != after.segment.piece:
                return np.zeros(columns.shape[1])
            return path(before, after, columns, *rest)

        monkeypatch.setattr(sliding_motion, "_delays", kept)
    wrong = differing(case_of(scene("capsule-turn/pivot")), ("half_time",))
    assert wrong


@pytest.mark.parametrize("name", ["capsule-coast/translation", "capsule-coast/rotation"])
def test_all_supports_stop_together(name: str) -> None:
    """Where a motion has a formula its derivatives through the rest are those of the formula."""
    case = case_of(scene(name))
    speed = "heading_rate" if name.endswith("rotation") else "velocity_x"
    observable = "heading" if name.endswith("rotation") else "x"
    end = np.array([case.scene.duration])
    found = exact_gradient(case, ["friction", "gravity", speed], end, [observable])
    way = float(case.reference.observe(end)[observable][0])
    for parameter in ("friction", "gravity"):
        slope = -way / case.scene.parameters[parameter]
        assert found[parameter].values[observable][0] == pytest.approx(slope, rel=1e-12)
    vx, vy = (case.scene.parameters[n] for n in ("velocity_x", "velocity_y"))
    # x = v_x |v|/(2 f g), the turn is proportional to the square of the rate.
    part = 2.0 if speed == "heading_rate" else 1.0 + vx**2 / (vx**2 + vy**2)
    slope = part * way / case.scene.parameters[speed]
    assert found[speed].values[observable][0] == pytest.approx(slope, rel=1e-12)


@pytest.mark.long(keep=0)
@pytest.mark.parametrize("by", ["to", "friction"])
def test_a_plan_reaches_its_goal_for_all_parameters_near(by: str) -> None:
    """The final pose of a plan, made anew for each parameter, has the goal as its derivative: on
    the way the manoeuvres change with it, at every event."""
    case = case_of(scene("capsule-plan/beside-curve-12"))
    times = np.array([0.4, 1.0]) * case.scene.duration
    found = exact_gradient(case, [by], times, ["x", "y", "heading"])
    for name, one in found.items():
        for index, (observable, values) in enumerate(one.values.items()):
            wanted = float(name == f"to[{index}]")
            assert abs(values[1] - wanted) <= one.uncertainty[observable][1] + 1e-12
            assert one.uncertainty[observable].max() <= ACCURATE
    assert max(abs(values[0]) for one in found.values() for values in one.values.values()) > 1e-4
