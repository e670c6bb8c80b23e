"""What a replay holds: few bytes, the exact motion to a pixel's fraction, runs from the store."""

import json
from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.systems.free_body.rotation import ATTITUDE
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import chosen_step_sizes, steps_beside
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.measurement import REFERENCE_STEP
from plumbob.engines.study.runner import most_steps
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import scenes as find_scenes
from plumbob.reports.analyses.replay import deviating, replay
from plumbob.reports.analyses.replay.capsule import motion
from plumbob.reports.analyses.replay.pendulums import pendulum
from plumbob.reports.analyses.replay.runs import (
    DEFAULT_METHOD,
    MOST_SWINGS,
    requests,
    shown_runs,
    shown_seconds,
)
from plumbob.reports.analyses.replay.samples import COUNTS, coded, sampled
from plumbob.tests.replay.all_replays import decoded, plan, recorded, replays

KILOBYTES = 160.0  # of a scene's data, in 24 bits a number
NAMES = [scene.name for scene in plan().scenes]
FRACTION = 2e-3  # of a channel's range, or of a radian: 0.4 pixel of 200


def test_a_scene_takes_few_bytes():
    assert [name for name in NAMES if len(replays()[name].data) >= 1e3 * KILOBYTES] == []


@pytest.mark.long
def test_the_largest_scene_of_the_full_profile_takes_few_bytes():
    """Long plans have the most samples; their recordings have at most some 500 each."""
    scene = find_scene("capsule-plan/half-turn-curve")
    shown = replay(replace(recorded(), scenes=(scene,)), scene)
    recordings = 2 * 500 * 4 * 4 * 4 / 3  # times, x, y, heading; four bytes in base64
    assert 0.5 * 1e3 * KILOBYTES < len(shown.data) + recordings < 1e3 * KILOBYTES, len(shown.data)


@pytest.mark.parametrize("name", NAMES)
def test_samples_follow_the_exact_motion_between_them(name):
    """At times that are no samples, interpolated as the page's script does it."""
    case, data = case_of(find_scene(name)), json.loads(replays()[name].data)
    layer, smooth = data["layers"][0], set(data["smooth"])
    samples = np.linspace(0.0, data["seconds"], layer["count"])
    times = np.linspace(0.0, data["seconds"], 977)
    exact = motion(case, times) if data["kind"] == "capsule" else case.reference.observe(times)
    for channel in ("theta", "theta_dot", "x", "y", "heading", "qx", "qy", *ATTITUDE):
        if channel not in layer["channels"]:
            continue
        values = decoded(layer["channels"][channel], layer["count"])
        found = between(samples, values, times, cubic=channel in smooth)
        span = float(np.ptp(exact[channel]))
        allowed = FRACTION * (span if channel == "theta_dot" or span <= 1.0 else 1.0)
        assert np.abs(found - exact[channel]).max() <= allowed + 1e-15, channel


def between(samples, values, times, *, cubic):
    """Values at `times`, by a line or a cubic through the nearest samples."""
    if not cubic:
        return np.interp(times, samples, values)
    first = np.clip(np.searchsorted(samples, times, side="right") - 2, 0, len(samples) - 4)
    found = np.zeros_like(times)
    for j in range(4):
        weight = np.ones_like(times)
        for k in range(4):
            if k != j:
                weight *= (times - samples[first + k]) / (samples[first + j] - samples[first + k])
        found += weight * values[first + j]
    return found


def test_fewer_samples_would_not_do():
    """The count found is the smallest that follows the motion: half as many do not."""

    def swing(times):
        return {"theta": np.sin(40.0 * times)}

    found = sampled(swing, 1.0, frozenset({"theta"}), frozenset())
    # A line departs by h^2/8 theta'' at most; 1e-3 rad are allowed.
    enough = [40.0**2 / 8.0 / (n - 1) ** 2 <= 1e-3 for n in COUNTS]
    assert enough == [False, False, True, True, True]
    assert len(found.times) == COUNTS[2]


@pytest.mark.parametrize("span", [1e-12, 1e-3, 1.0, 6.0, 500.0])
def test_numbers_survive_their_packing(span):
    values = span * np.sin(np.linspace(0.0, 20.0, 501)) + 0.3 * span
    assert np.abs(decoded(coded(values), 501) - values).max() <= 1e-7 * span
    assert coded(np.full(5, span)) == span


def test_a_replay_is_of_runs_of_the_study():
    """Whose errors stand beside it."""
    for scene in plan().scenes:
        shown = shown_runs(plan(), scene)
        assert [one.role for one in shown] == ["default", "recommended"]
        for one in shown:
            method = find_method(one.run.method)
            assert one.run == ExtraRun(scene.name, method.name, one.run.step)
            most = most_steps(scene, "quick")
            beside = steps_beside(scene, method, most)
            assert one.run.step in (*chosen_step_sizes(scene, method, most), *beside)


def test_both_runs_have_one_step():
    long = 0
    for scene in plan().scenes:
        default, recommended = shown_runs(plan(), scene)
        assert default.run.step == recommended.run.step
        long += default.run.step == REFERENCE_STEP
    assert long > 25  # of 35; the others are short


def test_the_largest_error_and_the_one_at_the_end_stand_beside_each_other():
    case = case_of(find_scene("simple-pendulum/free-small"))
    exact = case.reference.observe(np.array([0.0, 1.0, 2.0]))
    theta = exact["theta"] + np.array([0.0, 0.5, 0.25])
    run = Trajectory(np.array([0.0, 1.0, 2.0]), {**exact, "theta": theta}, {}, steps=2)
    picture = pendulum(case, 2.0)
    layer, _ = deviating(picture, run, "first", "", "")
    assert (layer.largest, layer.end) == ("0.5 rad", "0.25 rad")
    for layer in replays()["simple-pendulum/free-small"].layers[1:3]:
        assert layer.largest.endswith("rad")
        assert layer.end.endswith("rad")


@pytest.mark.parametrize("name", NAMES)
def test_recommended_settings_are_the_more_accurate_ones(name):
    data = json.loads(replays()[name].data)
    default, recommended = (_largest(layer) for layer in data["layers"][1:3])
    if find_scene(name).parameters.get("friction") == 0.0:  # contacts make no difference then
        assert recommended == pytest.approx(default, rel=1e-6)
    elif name == "rod-impact/sticks":  # what the step makes is as large, and falls with it
        assert recommended < 1.2 * default
    else:
        assert recommended < default


def _largest(layer):
    channels = {n: decoded(v, layer["count"]) for n, v in layer["channels"].items()}
    if "theta" in channels:
        return float(np.abs(channels["theta"]).max())
    if "heading" not in channels:
        return max(float(np.abs(values).max()) for values in channels.values())
    apart = np.hypot(channels["x"], channels["y"]) + 0.2 * np.abs(channels["heading"])
    return float(apart.max())


def test_a_users_own_settings_take_the_place_of_the_default_ones():
    own = replace(find_method(DEFAULT_METHOD), name="mujoco/mine", step_sizes=(4e-3, 2e-3))
    scene = find_scene("simple-pendulum/free-large")
    shown = shown_runs(StudyPlan("quick", (scene,), (own, *find_methods_of("mujoco/rk4"))), scene)
    assert [(one.role, one.run.step) for one in shown] == [("user", 4e-3), ("recommended", 4e-3)]


def find_methods_of(*names):
    return tuple(find_method(name) for name in names)


def test_a_plan_without_these_shows_its_first_methods():
    scene = find_scene("cone-pendulum/rotating-base")
    methods = find_methods_of("exact/closed-form", "ode/dop853", "ode/euler", "ode/rk4")
    shown = shown_runs(StudyPlan("quick", (scene,), methods), scene)
    assert [one.run.method for one in shown] == ["ode/dop853", "ode/euler"]
    assert shown[0].control == "tolerance"


def test_contacts_that_do_not_converge_are_not_recommended():
    scene = find_scene("capsule-line/ca1")
    methods = find_methods_of("mujoco/euler", "mujoco/rk4", "mujoco/euler+elliptic")
    shown = shown_runs(StudyPlan("quick", (scene,), methods), scene)
    assert [(one.role, one.run.method) for one in shown] == [
        ("default", "mujoco/euler"),
        ("other", "mujoco/rk4"),
    ]


def test_another_scene_of_the_same_name_has_no_runs():
    scene = replace(find_scene("cone-pendulum/rotating-base"), duration=0.1)
    assert shown_runs(plan(), scene) == ()


def test_thousands_of_swings_are_replayed_in_part():
    for scene in find_scenes("*/million-steps,*/thousand", "full"):
        assert shown_seconds(scene) < 0.2 * scene.duration
    turning = case_of(find_scene("cone-pendulum/million-steps"))
    assert shown_seconds(turning.scene) == MOST_SWINGS * turning.problem.motion.period
    part = StudyPlan("full", (turning.scene,), plan().methods)
    assert {run.duration for run in requests(part)} == {shown_seconds(turning.scene)}


def test_a_study_without_recordings_shows_the_exact_answer_alone():
    scene = find_scene("capsule-line/ca1")
    shown = replay(replace(recorded(), extras={}), scene)
    assert [layer.slot for layer in shown.layers] == ["exact"]
    assert len(shown.lacking) == 2
    assert shown.factors == (1, 10)


def test_the_linear_pendulum_is_drawn_beside_the_other():
    shown = replays()["simple-pendulum/free-large"]
    assert [layer.slot for layer in shown.layers] == ["exact", "first", "second", "companion"]
    data = json.loads(shown.data)
    theta = decoded(data["layers"][3]["channels"]["theta"], data["layers"][3]["count"])
    assert theta[0] == pytest.approx(-2.0943951, abs=1e-4)
    assert np.ptp(theta) == pytest.approx(2 * 2.0943951, rel=1e-3)  # it swings back to its start
    charts = [chart["y"] for chart in data["charts"]]
    assert charts == [["theta_dot"], ["x"], ["y"]]


def test_errors_on_paper_are_as_large_as_stay_small_in_the_picture():
    factors = {name: replays()[name].magnified for name in NAMES}
    assert factors["capsule-line/heading-030"] == 10
    assert set(factors.values()) <= {10**k for k in range(13)}


def test_a_diverged_or_missing_run_is_named():
    scene = find_scene("capsule-line/ca1")
    gone = {request: None for request in recorded().extras}
    shown = replay(replace(recorded(), extras=gone), scene)
    assert shown.lacking == ("mujoco/euler, 1 ms", "mujoco/euler+coulomb, 1 ms")


def test_the_speed_first_chosen_takes_some_seconds():
    for shown in replays().values():
        (speed,) = (choice.value for choice in shown.speeds if choice.chosen)
        assert 5.0 <= shown.seconds / speed <= 13.0
        assert len(shown.speeds) >= 3


def test_the_largest_factor_shows_the_smallest_errors():
    shown = replays()["simple-pendulum/free-large"]
    data = json.loads(shown.data)
    least = min(_largest(layer) for layer in data["layers"][1:3])
    assert 0.1 <= shown.factors[-1] * least < 1.0  # [rad]
    assert shown.factors[0] == 1
