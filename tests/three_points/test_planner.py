"""The planner: poses reached, limits observed, time compared with simple plans, sensitivity."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.systems.capsule import Capsule, lowest_normal_forces
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import closed_form
from plumbob.analytic.systems.planner.coordinate import along_curve
from plumbob.analytic.systems.planner.lines import quickest_push
from plumbob.analytic.systems.planner.manoeuvre import slow_arc, slow_line
from plumbob.analytic.systems.planner.problem import POSES, Limits, RestPose
from plumbob.analytic.systems.planner.result import Plan, pose_error, simulate
from plumbob.analytic.systems.planner.search import plan
from plumbob.analytic.systems.planner.tracks import ArcName
from plumbob.analytic.systems.planner.turns import outcome, quickest_drive
from plumbob.analytic.systems.slider_path import ArcPiece, SliderPath, StraightPiece, arc, straight
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.models.registry import scene
from plumbob.models.tripod_capsule.plan import BESIDE, CURVES, problem
from plumbob.reports.commands.plan import described
from plumbob.tests.support.random_capsules import CHECK

PLACES = dict(POSES)
CASES = tuple(itertools.product(PLACES, ("free", "curve")))
# In the full profile only: longer ways of the same mechanisms, and lines between other supports.
LATER = (("aside", "free"), ("aside", "curve"), ("behind", "free"), ("behind", "curve"),
         ("half-turn", "curve"))  # fmt: skip
LATER_PAIRS = (((1, 2), "longer"), ((3, 1), "longer"))
# The plan is exact: the errors of the reference remain, 1e-13 over a hundred segments.
REACHED = 1e-11
# A scalene triangle, without symmetry about C-A1.
SCALENE = Capsule(1.3, 0.4, 0.03, ((0.22, 0.03), (-0.09, 0.17), (-0.12, -0.14)), 0.25, 9.81)
FAR = Limits(acceleration=4000.0, stroke=1.0, radius=0.15)


@pytest.fixture(name="quick")
def _quick(pytestconfig: pytest.Config) -> bool:
    return bool(pytestconfig.getoption("profile") == "quick")


@pytest.fixture(autouse=True)
def _of_the_profile(request: pytest.FixtureRequest, quick: bool) -> None:
    """Skip a case of the full profile in the quick one."""
    given = request.node.callspec.params if hasattr(request.node, "callspec") else {}
    later = (given.get("name"), given.get("track", "curve")) in LATER
    later |= "case" not in given and (given.get("legs"), given.get("arc")) in LATER_PAIRS
    if quick and (later or given.get("profile") == "full"):
        pytest.skip("in the full profile")


@cache
def planned(name: str, track: str) -> Plan:
    """One of the suite's plans, made once in a process, with those that its scene is run with."""
    made: Plan = problem(scene(f"capsule-plan/{name}-{track}").parameters).motion
    assert (made.capsule, made.goal, made.track) == (CHECK, PLACES[name], track)
    assert made.limits == Limits()
    return made


def ends_off(body: Capsule, made: Plan) -> float:
    """Larger of the two errors of `body` after a plan [m or rad]."""
    motion = simulate(body, made)
    end = motion.at(np.array([max(made.duration, motion.rest_time)]))
    (x, y), heading = end.position[0], end.heading[0]
    return max(pose_error(RestPose(float(x), float(y), float(heading)), made.goal))


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(("name", "track"), CASES)
def test_every_pose_is_reached_at_rest_within_the_limits(name: str, track: str) -> None:
    made, limits = planned(name, track), Limits()
    assert max(made.error) <= REACHED
    assert made.path.end == pytest.approx(made.goal.slider, abs=1e-12)
    assert made.motion.rest_time <= made.duration
    assert made.duration <= scene(f"capsule-plan/{name}-{track}").duration < made.duration + 0.2
    assert made.turns + made.lines <= limits.manoeuvres
    assert (made.turns > 0) == (abs(PLACES[name].heading) > 0.0)
    assert lowest_normal_forces(CHECK, made.path.track())[0].min() > 0.0
    for one in made.manoeuvres:
        for piece in one.path.pieces:
            # |w| is constant on a line and largest where the speed is on a circle.
            strength = np.linalg.norm(piece.kinematics(np.array([0.0, piece.duration]))[2], axis=1)
            assert strength.max() <= limits.acceleration * (1.0 + 1e-12)
        if one.kind == "turn":
            given = one.parameters
            way = given["radius"] * given["angular_acceleration"] * given["half_time"] ** 2
            assert given["radius"] == limits.radius
            assert abs(way) <= limits.stroke * (1.0 + 1e-12)
        if one.kind == "line":
            given = one.parameters
            stroke = closed_form(CHECK, given["w1"], given["w2"], given["t1"]).stroke
            assert stroke <= limits.stroke * (1.0 + 1e-12)
            assert track == "free" or stroke <= limits.radius * (1.0 + 1e-12)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(("name", "track"), CASES)
def test_the_body_rests_between_manoeuvres_and_in_slow_ones(name: str, track: str) -> None:
    made = planned(name, track)
    moving = np.array([one.kind == "wait" for one in made.manoeuvres])
    slow = [k for k, one in enumerate(made.manoeuvres) if one.kind == "slow"]
    before = made.motion.at(np.array([one.start for one in made.manoeuvres]))
    after = made.motion.at(made.ends)
    # A start is rounded by 4e-15 s, and the body then accelerates at some 1e3 rad/s^2 or m/s^2.
    still = 1e-11
    assert np.abs(before.velocity[~moving]).max() <= still
    assert np.abs(before.angular_velocity[~moving]).max() <= still
    assert np.abs(after.position[slow] - before.position[slow]).max() <= still
    assert np.abs(after.heading[slow] - before.heading[slow]).max() <= still


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("name", PLACES)
def test_the_curve_has_one_degree_of_freedom(name: str) -> None:
    made = planned(name, "curve")
    along, times = along_curve(made), np.linspace(0.0, made.duration, 4001)
    # Places on the curve are sums over some hundred pieces.
    assert np.abs(along.slider(times) - made.slider(times)).max() <= 1e-12
    speed = np.linalg.norm(made.relative_velocity(times), axis=1)
    assert np.abs(np.abs(along.rate(times)) - speed).max() <= 1e-11
    reached = along.rate(times[:1]) + np.cumsum(along.mean_acceleration(times) * np.diff(times))
    assert np.abs(reached - along.rate(times[1:])).max() <= 1e-11


PAIRS = tuple(itertools.product(((1, 2), (2, 3), (3, 1)), ("shorter", "longer")))


@cache
def on_curve(legs: tuple[int, int], arc: ArcName) -> Plan:
    """The plan of the scalene body along a pair of lines and an arc between them."""
    return plan(SCALENE, BESIDE, track="curve", legs=legs, arc=arc)


@pytest.mark.long
@pytest.mark.parametrize(("legs", "arc"), PAIRS)
def test_the_curve_may_have_any_two_lines_and_either_arc(
    legs: tuple[int, int], arc: ArcName
) -> None:
    made = on_curve(legs, arc)
    assert max(made.error) <= REACHED
    along, times = along_curve(made), np.linspace(0.0, made.duration, 2001)
    place = made.slider(times) @ [1.0, 1.0j]
    assert np.abs(along.slider(times) @ [1.0, 1.0j] - place).max() <= 1e-12
    # without the track's own words: on a line to one of the two supports, or on the circle
    radius = made.limits.radius
    assert np.abs(place).max() <= radius * (1 + 1e-12)
    ends = [complex(*SCALENE.supports[i - 1]) for i in legs]
    off_lines = [abs((place / (end / abs(end))).imag) for end in ends]
    on_circle = np.abs(np.abs(place) - radius) <= 1e-9
    on_line = (np.minimum(*off_lines) <= 1e-9) & (np.abs(place) <= radius + 1e-9)
    assert (on_line | on_circle).all()
    for off in off_lines:  # both are gone along
        assert (np.abs(place)[(off <= 1e-9) & ~on_circle] > 0.1 * radius).any()
    turned = np.abs(np.angle(place[on_circle] / ends[0]))
    between = abs(np.angle(ends[1] / ends[0]))
    way = np.angle(place[on_circle] / ends[0]) * np.sign(np.angle(ends[1] / ends[0]))
    inner = (way > 1e-6) & (turned < between - 1e-6)
    outer = (way < -1e-6) | (turned > between + 1e-6)
    assert (inner.any(), outer.any()) == ((True, False) if arc == "shorter" else (False, True))


@pytest.mark.parametrize(("case", "legs", "arc", "lasting", "profile"), CURVES)
def test_scenes_of_other_curves_last_until_the_body_rests(
    case: str, legs: tuple[int, int], arc: ArcName, lasting: float, profile: str
) -> None:
    given = scene(f"capsule-plan/beside-curve-{case}")
    made = problem(given.parameters).motion
    assert (made.legs, made.arc, made.goal) == (legs, arc, BESIDE)
    assert max(made.error) <= REACHED
    assert made.duration <= given.duration == lasting < made.duration + 0.2


def test_a_mean_acceleration_held_over_steps_gives_the_velocity_at_every_edge() -> None:
    made = planned("near", "free")
    edges = np.linspace(0.0, made.duration, 1000)
    held = made.mean_relative_acceleration(edges)
    assert held.shape == (999, 2)
    reached = np.cumsum(held * np.diff(edges)[:, None], axis=0)
    # A thousand roundings of speeds of up to 10 m/s.
    assert np.abs(reached - made.relative_velocity(edges[1:])).max() <= 1e-11


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "track", "least"), [("half-turn", "free", 7.0), ("ahead", "curve", 1.6)]
)
def test_minimum_time_is_below_that_of_equal_manoeuvres(
    name: str, track: str, least: float
) -> None:
    naive = plan(CHECK, PLACES[name], track=track, equal=True)  # type: ignore[arg-type]
    assert max(naive.error) <= REACHED
    assert naive.duration >= least * planned(name, track).duration


@given(st.floats(1.2, 70.0), st.floats(0.05, 0.9))
def test_no_push_within_the_limits_is_quicker(push: float, pull: float) -> None:
    limits, threshold = Limits(), CHECK.holding_acceleration
    best = quickest_push(CHECK, limits)

    def time(w1: float, w2: float) -> float:
        """For one displacement, with the slow return (Chernousko 2020, eqs. 17, 18, 22)."""
        unit = closed_form(CHECK, w1, w2, 1.0)
        back = 2.0 * math.sqrt(unit.stroke / (limits.holding * threshold))
        return (unit.t2 + back) / math.sqrt(-unit.displacement)

    assert time(best.w1, best.w2) <= time(push * threshold, pull * threshold)


def test_a_weaker_drive_turns_less_in_more_time() -> None:
    full = quickest_drive(Limits())(1.0)
    at_limit, below = (outcome(CHECK, 0.12, 0.3, 1.0, drive) for drive in (full, 0.8 * full))
    assert abs(below.heading) < abs(at_limit.heading)
    assert below.manoeuvre.duration + below.pause > at_limit.manoeuvre.duration + at_limit.pause


def quickened(path: SliderPath, factor: float) -> SliderPath:
    """The same path in less time: every acceleration times `factor`."""
    pieces = [p for p in path.pieces if isinstance(p, (ArcPiece, StraightPiece))]
    times = [p.duration / math.sqrt(factor) for p in pieces]
    rates, first = [factor * p.acceleration for p in pieces], pieces[0]
    if isinstance(first, ArcPiece):
        return arc(first.radius, first.angle, rates, times)
    return straight(first.origin, first.direction, rates, times)


@pytest.mark.parametrize("body", [CHECK, SCALENE])
def test_slow_motions_reach_the_friction_limit_and_no_more(body: Capsule) -> None:
    a = 0.12
    for slow in (
        slow_line(body, 0j, a + 0j, 1.0),
        slow_line(body, a + 0j, a * complex(math.cos(1.0), math.sin(1.0)), 1.0),
        slow_arc(body, a, 0.3, 2.4, 1.0),
    ):
        assert three_point_motion(body, slow.path).events[0].mode == "rest"
        assert len(three_point_motion(body, slow.path).events) == 1
        assert len(three_point_motion(body, quickened(slow.path, 1.01)).events) > 1
    radial = slow_line(body, 0j, a + 0j, 0.9).parameters["acceleration"]
    assert radial == pytest.approx(0.9 * body.holding_acceleration, rel=1e-12)
    across = slow_arc(body, a, 0.3, 0.31, 1.0).parameters["angular_acceleration"] * a
    assert 0.7 < across / body.holding_acceleration < 0.9


@pytest.mark.long
@settings(max_examples=3)
@given(
    st.sampled_from([CHECK, SCALENE]),
    st.sampled_from(["free", "curve"]),
    st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-2.0, 2.0)),
    st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-4.0, 4.0)),
    st.sampled_from([(0.0, 0.0), (0.15, 0.0)]),
)
def test_any_pose_from_any_pose(body, track, step, begin, slider) -> None:  # type: ignore[no-untyped-def]
    if body is SCALENE:
        slider = (0.0, 0.0)  # the other position is not on its curve
    start = RestPose(begin[0], begin[1], begin[2], slider)
    goal = RestPose(begin[0] + step[0], begin[1] + step[1], begin[2] + step[2])
    assert max(plan(body, goal, FAR, track, start).error) <= REACHED


@pytest.mark.parametrize("turns", [-3, 0, 1])
def test_headings_are_alike_up_to_whole_turns(turns: int) -> None:
    there = RestPose(1.0, 2.0, 3.0 + 2.0 * math.pi * turns)
    assert pose_error(there, RestPose(1.0, 2.0, 3.0)) == pytest.approx((0.0, 0.0), abs=1e-14)
    distance, angle = pose_error(there, RestPose(1.3, 1.6, -3.0))
    assert (distance, angle) == pytest.approx((0.5, 2.0 * math.pi - 6.0), abs=1e-14)


def test_what_is_said_of_a_plan_s_error() -> None:
    made = planned(next(iter(PLACES)), "free")
    elsewhere = RestPose(made.goal.x + 0.3, made.goal.y - 0.4, made.goal.heading + 0.1)
    said = described(replace(made, goal=elsewhere))
    assert said["position_error"] == pytest.approx(0.5, abs=1e-9)
    assert said["heading_error"] == pytest.approx(0.1, abs=1e-9)


@pytest.mark.long
def test_a_plan_does_not_depend_on_the_axes() -> None:
    goal, turned = PLACES["near"], 1.234
    place = goal.place * complex(math.cos(turned), math.sin(turned)) + 3.0
    start = RestPose(3.0, 0.0, turned)
    moved = plan(CHECK, RestPose(place.real, place.imag, goal.heading + turned), start=start)
    assert moved.duration == pytest.approx(planned("near", "free").duration, rel=1e-9)
    assert max(moved.error) <= REACHED


def test_a_pose_already_taken_needs_no_manoeuvre() -> None:
    made = plan(CHECK, RestPose(0.0, 0.0, 2.0 * math.pi))
    assert (made.duration, made.manoeuvres) == (0.0, ())
    assert made.error == (0.0, 0.0)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    "body",
    [
        replace(CHECK, friction=0.3 * (1 + 1e-4)),
        replace(CHECK, inertia=0.02 * (1 + 1e-4)),
        replace(CHECK, supports=((0.2 * (1 + 1e-4), 0.0), *CHECK.supports[1:])),
    ],
)
def test_sensitivity_to_the_body(body: Capsule) -> None:
    assert ends_off(CHECK, planned("near", "free")) <= REACHED
    assert ends_off(body, planned("near", "free")) > 1e-6


@pytest.mark.long
def test_the_order_of_the_legs_does_not_matter_and_the_pair_does(quick: bool) -> None:
    reversed_ = plan(SCALENE, BESIDE, track="curve", legs=(2, 1))
    assert reversed_.duration == pytest.approx(on_curve((1, 2), "shorter").duration, rel=1e-9)
    pairs = [pair for pair in PAIRS if not (quick and pair in LATER_PAIRS)]
    times = {pair: on_curve(*pair).duration for pair in pairs}
    assert min(times, key=lambda pair: times[pair]) == ((2, 3), "shorter")
    assert max(times.values()) > 1.4 * min(times.values())
    assert plan(SCALENE, BESIDE, track="curve").duration == times[(1, 2), "shorter"]


@pytest.mark.parametrize("legs", [(1, 1), (1, 4), (1,), (1, 2, 3), (1.0, 2), [1, 2], "12", 0])
def test_legs_that_are_no_pair_are_refused(legs: object) -> None:
    with pytest.raises(ParameterError, match="legs"):
        plan(CHECK, PLACES["near"], track="curve", legs=legs)  # type: ignore[arg-type]
