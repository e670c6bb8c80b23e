"""Means over episodes: 95 % intervals that cover exact differences, and limits of small steps."""

import json
import math
from dataclasses import replace
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from plumbob import audit
from plumbob.engines.audit.episodes import EpisodePlan, ModelEpisodes
from plumbob.engines.audit.mean_returns import interval_of, limit_of
from plumbob.reports.cli import main
from plumbob.tests.audit import looped_policies as policies
from plumbob.tests.audit.test_audit_in_the_loop import CART, HELD, LINE

STIFFNESS, DAMPING = 9.0, 2.5  # [1/s^2], [1/s] of the oscillator x'' = u - d x' - k x
PERIOD = 0.2  # [s] for which a random control is held
KEPT = 40  # periods whose squares an episode's return is the mean of


def period_map(parts):
    """Semi-implicit Euler over a period in `parts` steps: matrix of the state, effect of a
    control."""
    h = PERIOD / parts
    rate = [-h * STIFFNESS, 1 - h * DAMPING]
    step = np.array([[1 + h * rate[0], h * rate[1]], rate])
    push = np.array([h * h, h])
    matrix, effect = np.eye(2), np.zeros(2)
    for _ in range(parts):
        matrix, effect = step @ matrix, step @ effect + push
    return matrix, effect


def mean_square(parts):
    """Exact mean of x^2 under controls of variance 1: the discrete Lyapunov equation."""
    matrix, effect = period_map(parts)
    return solve_discrete_lyapunov(matrix, np.outer(effect, effect))[0, 0]


def episodes(parts, controls, start):
    """Mean squares of x of episodes, shape (n,), under controls, shape (n, KEPT)."""
    matrix, effect = period_map(parts)
    state = (
        start @ np.linalg.cholesky(solve_discrete_lyapunov(matrix, np.outer(effect, effect))).T
    )
    squares = np.zeros(len(controls))
    for control in controls.T:
        state = state @ matrix.T + control[:, None] * effect
        squares += state[:, 0] ** 2 / controls.shape[1]
    return squares


def coverage(count, repetitions):
    """Fractions of repetitions whose intervals of t and of the bootstrap cover the exact difference
    between two steps. Starts are drawn from the stationary state, so that the mean is exact."""
    draw = np.random.default_rng(1)
    exact = mean_square(8) - mean_square(4)
    covered = []
    for _ in range(repetitions):
        controls, start = draw.normal(size=(count, KEPT)), draw.normal(size=(count, 2))
        found = interval_of(episodes(8, controls, start) - episodes(4, controls, start))
        covered.append(
            (
                found.low <= exact <= found.high,
                found.bootstrap_low <= exact <= found.bootstrap_high,
            )
        )
    return np.mean(covered, axis=0)


@pytest.mark.rare
@pytest.mark.parametrize("count", [24, 100])
def test_intervals_cover_the_exact_difference(count):
    by_t, by_bootstrap = coverage(count, 2000)
    # 2000 repetitions of 0.95 scatter by 0.005
    assert 0.93 <= by_t <= 0.97
    # the bootstrap of so few is known to be narrower
    assert 0.90 <= by_bootstrap <= 0.97


def test_a_few_intervals_cover_the_exact_difference():
    # 200 repetitions of 0.95 scatter by 0.015
    assert 0.9 <= coverage(24, 200)[0] <= 0.995


def test_the_limit_is_that_of_the_exact_mean_squares():
    """With thousands of episodes the extrapolated limit is that of the Lyapunov equation at tiny
    steps, and the fitted order is that equation's own."""
    draw = np.random.default_rng(2)
    controls, start = draw.normal(size=(4000, KEPT)), draw.normal(size=(4000, 2))
    returns = [episodes(parts, controls, start) for parts in (4, 8, 16)]
    limit, why = limit_of(returns, 1)
    assert not why
    exact = mean_square(4096) - mean_square(4)
    assert limit.low <= exact <= limit.high
    # most of it is what the next order leaves, which is as large as the first here
    assert limit.half < 0.25 * abs(exact)
    changes = [mean_square(2 * n) - mean_square(n) for n in (4, 8)]
    first, second = (interval_of(finer - coarser) for coarser, finer in pairwise(returns))
    order, own = (math.log2(a / b) for a, b in ((first.mean, second.mean), changes))
    # the two differences are known to 5 % and 8 %: 0.15 of an order
    assert order == pytest.approx(own, abs=0.15)
    assert limit_of(returns, 4) == (
        None,
        "its changes do not fall as the step to the power 4",
    )


def test_no_limit_of_differences_that_are_not_resolved():
    draw = np.random.default_rng(3)
    limit, why = limit_of([draw.normal(size=24) for _ in range(3)], 1)
    assert limit is None
    assert "less than the episodes resolve" in why


def test_equal_values_have_an_interval_of_no_width():
    found = interval_of(np.full(5, 2.0))
    assert (found.low, found.high, found.bootstrap_low, found.bootstrap_high) == (2.0,) * 4


def looped(count, **options):
    return audit(
        mujoco.MjModel.from_xml_string(CART),
        keyframe=0,
        policy=policies.balance,
        in_the_loop=True,
        period=HELD,
        duration=0.2,
        budget=3.0,
        episodes=EpisodePlan(count, policies.mean_angle),
        **options,
    )


def test_episodes_are_runs_in_the_loop_from_paired_starts():
    found = looped(6)
    own, half, quarter, *others = found.returns.rows
    assert [row.step for row in (own, half, quarter)] == pytest.approx([0.01, 0.005, 0.0025])
    assert [row.integrator for row in others] == list(found.model.integrators[1:])
    assert (own.difference, own.episodes, own.lost) == (None, 6, 0)
    model = mujoco.MjModel.from_xml_string(CART)
    model.opt.timestep /= 2
    script = replace(found.script, loop=None)
    starts = ModelEpisodes(found.model, script, policies.mean_angle)
    angles = []
    for number in range(6):
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = np.split(starts.start(number), 2)
        course = [data.qpos[1]]
        for period in range(10):
            data.ctrl[:] = policies.balance(period * HELD, data.qpos, data.qvel)
            mujoco.mj_step(model, data, 4)
            course.append(data.qpos[1])
        angles.append(np.mean(course))
    assert half.mean.mean == pytest.approx(np.mean(angles), rel=1e-12)
    assert np.ptp(angles) > 1e-4  # the starts differ
    # pairs resolve what the step does to a thousandth of the spread of the returns
    assert quarter.difference.half < 0.05 * own.mean.half
    assert found.returns.limit is not None
    assert found.returns.within(0.5)
    found.assert_return_within(0.5)
    with pytest.raises(
        AssertionError, match=r"may change the mean return by more than 0.001 %"
    ):
        found.assert_return_within(1e-5)


EPISODES = ["--policy", "plumbob.tests.audit.looped_policies:balance", "--duration", "0.1"]
METRIC = "plumbob.tests.audit.looped_policies:"


def test_on_the_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cart.xml").write_text(CART)
    line = [*LINE, *EPISODES, "--budget", "2", "--episodes", "4", "--metric"]
    assert main([*line, f"{METRIC}mean_angle", "--return-within", "50%"]) == 0
    second = capsys.readouterr().out.splitlines()[1]
    assert second.startswith("return ")
    assert "% of the return is the step's; mean" in second
    assert main([*line, f"{METRIC}mean_angle", "--return-within", "0.001%", "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    rows = answer["returns"]
    assert rows[0]["difference"] is None
    assert rows[1]["low"] <= rows[1]["difference"] <= rows[1]["high"]
    assert {row["episodes"] for row in rows} == {4}
    assert answer["return_limit"]["low"] <= answer["return_limit"]["high"]


WRONG = [
    (["--episodes", "4"], "episodes = 4: must be given with --metric"),
    (["--metric", f"{METRIC}mean_angle"], "given with --episodes"),
    (["--episodes", "1", "--metric", f"{METRIC}mean_angle"], "a number from 2 to"),
    (["--episodes", "4", "--metric", "no:such"], "MODULE:FUNCTION"),
    (
        ["--episodes", "4", "--metric", f"{METRIC}mean_angle", "--spread", "1e308"],
        "spread = 1e+308: must be at most 1e+06",
    ),
    (["--duration", "1e308"], "duration = 1e+308: must be at most 100000 periods"),
    (["--episodes", "4", "--metric", f"{METRIC}raises"], "that returns a finite number"),
    (["--episodes", "4", "--metric", f"{METRIC}no_number"], "not nan"),
]


@pytest.mark.long(keep=2)
@pytest.mark.parametrize(("options", "message"), WRONG, ids=lambda value: value[-1][-12:])
def test_wrong_use_is_one_line(options, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cart.xml").write_text(CART)
    assert main([*LINE, *EPISODES, "--budget", "1", *options]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert message in err
