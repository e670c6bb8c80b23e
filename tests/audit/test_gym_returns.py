"""An environment of Gymnasium in the loop: its own code observes and rewards, whatever moves its
state."""

import importlib
import json
import warnings
from pathlib import Path

import numpy as np
import pytest

from plumbob import audit, load
from plumbob.engines import closed_loop
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.environment_returns import EnvironmentEpisodes
from plumbob.engines.audit.environments import environment, rollout, start_and_period
from plumbob.engines.audit.episodes import EpisodePlan, episode_returns
from plumbob.engines.audit.mean_returns import Setting
from plumbob.engines.audit.reference import largest_distances
from plumbob.engines.audit.user_models import user_models
from plumbob.engines.closed_loop import NamedPolicy
from plumbob.engines.own_motion import AS_IT_STANDS, Script
from plumbob.engines.workers import Workers
from plumbob.reports.cli import main
from plumbob.tests.audit import looped_policies as policies
from plumbob.tests.validation.loop_findings import Rhythm

for package in ("gymnasium", "imageio"):
    pytest.importorskip(package)

HERE = Path(policies.__file__).parent
POLE, DOUBLE = "InvertedPendulum-v5", "InvertedDoublePendulum-v5"
STEER = NamedPolicy("looped_policies:steers", str(HERE))
# An environment, the number of its actions, and its control period [s]
BODIES = [("HalfCheetah-v5", 6, 0.05), ("Hopper-v5", 3, 0.008)]


def swings(observation):
    """Actions of a rhythm with feedback, for any environment with six joints or fewer."""
    return 0.5 * np.cos(np.arange(6) - observation[2])


@pytest.mark.parametrize(("name", "count", "period"), BODIES)
def test_the_rollout_at_the_own_step_is_gymnasiums_to_the_bit(name, count, period):
    """The environment's simulator is swapped, and its rewards and observations stay the same."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        theirs = importlib.import_module("gymnasium").make(name)
        seen, _ = theirs.reset(seed=4)
        rewards, states = [], []
        for _ in range(60):
            seen, reward, ended, *_ = theirs.step(swings(seen)[:count])
            rewards.append(reward)
            states.append(theirs.unwrapped.state_vector())
            if ended:
                break
    ours = environment(name, seed=4)
    model = user_models().model(ours.unwrapped.data, AS_IT_STANDS)
    assert period == pytest.approx(ours.unwrapped.dt)
    move = model.moving_data(model.integrator, period, ours.unwrapped.frame_skip)
    seen, _ = ours.reset(seed=4)
    found = rollout(ours, seen, lambda seen: swings(seen)[:count], 60, move)
    np.testing.assert_array_equal(found.rewards, rewards)
    np.testing.assert_array_equal(found.states, states)
    assert len(rewards) > 20


def in_the_loop(name=POLE, policy=STEER, **options):
    options = {"duration": 0.2, "budget": 5.0, **options}
    return audit(environment(name, seed=3), policy=policy, in_the_loop=True, **options)


@pytest.mark.rare
def test_the_return_of_the_continuous_motion():
    """The reward of an inverted pendulum is 1 a period; that of a double one reads the tip's place,
    which lags a step."""
    found = in_the_loop().motion_return
    assert (found.own, found.limit_until, found.lag) == (5.0, 5.0, 0.0)
    assert (found.until, found.ended) == (pytest.approx(0.2), False)
    double = in_the_loop(DOUBLE)
    found = double.motion_return
    assert found.uncertainty < 1e-6 < abs(found.own - found.limit_until)
    assert found.lag != 0.0
    # Steps that are eight times smaller tend to the limit, less what rewards lag
    source = EnvironmentEpisodes(
        environment(DOUBLE, seed=3),
        3,
        STEER,
        double.model,
        double.script,
    )
    parts = double.script.parts(double.step)
    fine = [
        source.outcome(0, Setting("rk4", double.step / n, parts * n))[0] for n in (1, 8, 64)
    ]
    errors = [abs(value - found.limit_until) for value in fine]
    assert errors[0] > 4.0 * errors[1] > 16.0 * errors[2]


@pytest.mark.rare
def test_an_episode_that_the_environment_ends_counts_to_its_end():
    found = in_the_loop(policy=policies.falls, duration=2.0, budget=3.0).motion_return
    assert found.ended
    assert found.duration < 1.0
    assert found.until <= found.duration


def episodes(folder, count=6, policy=STEER, jobs=1):
    """Returns of episodes of 0.4 s, with their outcomes stored in a folder."""
    made = environment(DOUBLE, seed=3)
    start, period = start_and_period(made)
    model = user_models().model(start, AS_IT_STANDS)
    script = Script(model.state, period, np.zeros((round(0.4 / period), 1)))
    source = EnvironmentEpisodes(made.spec, 3, policy, model, script)
    plan = EpisodePlan(count, file=folder / "kept.sqlite3")
    with Workers(jobs) as workers:
        return episode_returns(source, plan, Allowance(5.0, workers))


@pytest.mark.long(keep=1)
def test_episodes_are_resets_with_seeds_in_one_process_or_two(tmp_path, monkeypatch):
    alone = episodes(tmp_path / "alone")
    both = episodes(tmp_path / "both", jobs=2)
    np.testing.assert_array_equal(alone.values, both.values)
    assert [row.integrator for row in alone.rows[:3]] == [alone.own.integrator] * 3
    assert alone.own.length <= 0.4
    assert alone.own.lost == 0
    assert np.ptp(alone.values[:, 0]) > 0.1  # the starts differ
    # Outcomes that are stored are not run again, apart from the first.
    numbers = []
    outcome = EnvironmentEpisodes.outcome
    monkeypatch.setattr(
        EnvironmentEpisodes,
        "outcome",
        lambda self, number, setting: numbers.append(number) or outcome(self, number, setting),
    )
    again = episodes(tmp_path / "alone", count=7)
    np.testing.assert_array_equal(again.values[:6], alone.values)
    assert set(numbers) == {0, 6}
    # A policy that answers otherwise under the same name has other outcomes.
    numbers.clear()
    monkeypatch.setattr(policies, "STEERING", 8.0)
    episodes(tmp_path / "alone", policy=policies.steers)
    numbers.clear()
    monkeypatch.setattr(policies, "STEERING", 3.0)
    episodes(tmp_path / "alone", policy=policies.steers)
    assert set(numbers) == set(range(6))


HOSTILE = {
    "raises_at_observation": "(KeyError: 'nothing')",
    "no_number_at_observation": "returns [nan] at 0 s",
    "three_actions": "Action dimension mismatch",
    "sleeps_at_observation": "answers to a run take at most 0.2 s",
    "leaves_at_observation": "(SystemExit: 0)",
    "counts_observations": "asked again at 0 s, it answers otherwise",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_policies_are_one_line(name, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(closed_loop, "LONGEST_ANSWERS", 0.2)
    policy = f"plumbob.tests.audit.looped_policies:{name}"
    line = ["audit", "--gym", POLE, "--in-the-loop", "--duration", "0.1", "--budget", "1"]
    assert main([*line, "--policy", policy]) == 2
    err = capsys.readouterr().err
    assert (err.count("\n"), "policy = " in err) == (1, True)
    assert HOSTILE[name] in err


def test_an_environment_that_steps_elsewhere_is_refused():
    own = environment(POLE)
    inner = own.unwrapped
    inner.do_simulation = lambda control, frames: None
    with pytest.raises(Exception, match=r"calls MujocoEnv\.do_simulation once an action"):
        audit(own, policy=STEER, in_the_loop=True, duration=0.1, budget=1.0)


def test_on_the_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    policy = ["--policy", "plumbob.tests.audit.looped_policies:steers"]
    line = ["audit", "--gym", POLE, *policy, "--duration", "0.2", "--budget", "1"]
    line += ["--in-the-loop", "--episodes", "4"]
    assert main([*line, "--out", "pages", "--return-within", "1%"]) == 0
    text = capsys.readouterr().out
    assert "return 5 at 20 ms, over 0.2 s; in the continuous limit 5 ± 0" in text
    assert "no reward reads a quantity of the step before" in text
    assert "Return against step" in (Path("pages") / f"audit-{POLE}.html").read_text("utf-8")
    answer = json.loads((Path("pages") / f"audit-{POLE}.json").read_text("utf-8"))
    assert load("pages").returns["mean"].tolist() == [r["mean"] for r in answer["returns"]]
    assert answer["motion_return"]["own"] == 5.0
    assert answer["returns"][0]["length"] == pytest.approx(0.2)
    for wrong, message in (
        (["--episodes", "4"], "given with --in-the-loop"),
        (["--in-the-loop", "--episodes", "4", "--metric", "a:b"], "left out with --gym"),
        (["--in-the-loop", "--episodes", "4", "--spread", "1"], "left out with --gym"),
    ):
        assert main([*line[:5], *wrong]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.rare
def test_steps_256_times_smaller_confirm_the_certificate_of_a_half_cheetah():
    """Under a rhythm with feedback, through 60 events of contacts, in the loop of each run."""
    found = audit(
        environment("HalfCheetah-v5"),
        policy=Rhythm(0.1),
        in_the_loop=True,
        duration=1.0,
        budget=15.0,
    )
    assert found.until == pytest.approx(1.0)
    parts = 256 * found.script.parts(found.step)
    fine = found.model.stepped(found.script, "rk4", parts).states
    apart = largest_distances(found.reference.corners, found.model.corners(fine))[-1]
    # RK4 is of first order at contacts: its steps of 39 us are themselves wrong by a micrometre.
    assert apart < found.uncertainty + 2e-6
    assert found.error > 1e4 * apart
    assert found.motion_return.uncertainty < 1e-3
