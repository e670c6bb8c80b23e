"""What a replay holds: few bytes, the exact motion to a pixel's fraction, runs from the store."""

import json
from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import chosen_step_sizes, steps_beside
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.runner import most_steps
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.replay.coordinates import shown_observables
from plumbob.reports.analyses.replay.runs import shown_runs
from plumbob.tests.replay.all_replays import decoded, plan, replay_of

KILOBYTES = 160.0  # of a scene's data, in 24 bits a number
NAMES = [scene.name for scene in plan().scenes]
FRACTION = 2e-3  # of a channel's range, or of a radian: 0.4 pixel of 200


@pytest.mark.long(keep=8)
@pytest.mark.parametrize("name", NAMES)
def test_samples_follow_the_exact_motion_between_them(name):
    """The coordinates have the exact observables also between samples, interpolated as the page's
    script does it."""
    data = json.loads(replay_of(name).data)
    assert len(replay_of(name).data) < 1e3 * KILOBYTES
    case = case_of(find_scene(name)).lasting(data["seconds"])
    layer = data["layers"][0]
    samples = np.linspace(0.0, data["seconds"], layer["count"])
    times = np.linspace(0.0, data["seconds"], 977)
    exact = case.reference.observe(times)
    channels = [decoded(channel, layer["count"]) for channel in layer["channels"]]
    coordinates = np.stack([np.interp(times, samples, values) for values in channels], axis=1)
    shown = shown_observables(case, coordinates)
    assert shown.keys() & exact.keys()
    for observable in shown.keys() & exact.keys():
        span = float(np.ptp(exact[observable]))
        allowed = FRACTION * min(span, 1.0)
        error = np.abs(shown[observable] - exact[observable]).max()
        assert error <= allowed + 1e-9, observable


def test_a_replay_is_of_runs_of_the_study():
    """Whose errors stand beside it."""
    for name in NAMES:
        scene = find_scene(name)
        shown = shown_runs(plan(), scene)
        assert [one.words for one in shown] == [
            "default settings but for the step",
            "recommended settings",
        ]
        for one in shown:
            method = find_method(one.run.method)
            assert one.run == ExtraRun(scene.name, method.name, one.run.step)
            most = most_steps(scene, "quick")
            beside = steps_beside(scene, method, most)
            assert one.run.step in (*chosen_step_sizes(scene, method, most), *beside)


def test_a_users_own_settings_take_the_place_of_the_default_ones():
    own = replace(find_method("mujoco/euler"), name="mujoco/mine", step_sizes=(4e-3, 2e-3))
    scene = find_scene("simple-pendulum/free-large")
    shown = shown_runs(
        StudyPlan("quick", (scene,), (own, *find_methods_of("mujoco/rk4"))), scene
    )
    assert [(one.words, one.run.step) for one in shown] == [
        ("your settings", 4e-3),
        ("recommended settings", 4e-3),
    ]


def find_methods_of(*names):
    return tuple(find_method(name) for name in names)
