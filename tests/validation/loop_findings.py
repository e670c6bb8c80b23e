"""Compute the numbers of findings on policies in the loop, which no study measures, and write them
into the files of `reports/exact_numbers` that are shipped with the package.

    python -m plumbob.tests.validation.loop_findings [TEMPLATE ...]

Takes some minutes; needs Gymnasium. The policies of `engines/trained_policies` are the linear ones
that `trained_policies.py` writes.
"""

import sys
from pathlib import Path

import mujoco
import numpy as np
from scipy.linalg import expm, solve_continuous_are

from plumbob.analytic.systems.held_loop import first_unstable, loop_multiplier
from plumbob.engines.audit.environment_returns import EnvironmentEpisodes
from plumbob.engines.audit.environments import environment, start_and_period
from plumbob.engines.audit.episodes import outcomes_of
from plumbob.engines.audit.loop_stability import FedBackModel, loop_stability
from plumbob.engines.audit.mean_returns import Setting, interval_of, returns_of
from plumbob.engines.audit.user_models import quiet, user_models
from plumbob.engines.closed_loop import ClosedLoop
from plumbob.engines.own_motion import AS_IT_STANDS, Script
from plumbob.engines.study.provenance import provenance
from plumbob.reports.records.exact_numbers import ExactNumbers, exact_numbers_file
from plumbob.reports.records.plain_data import FOR_TEMPLATES, plain
from plumbob.reports.view.audit.records import loop_record
from plumbob.tests.validation.exact_numbers import text_of
from plumbob.tests.validation.trained_policies import FOLDER, TASKS

PACKAGES = ("plumbob", "Python", "numpy", "scipy", "mujoco")
CART_POLE = Path(__file__).with_name("cart_pole.xml")
HOLD = 2  # steps of 10 ms between two samples
FEEDBACKS = (0.02, 0.1)
CHEETAH = "HalfCheetah-v5"
FINER = (1, 2, 4, 8, 16)
STARTS = 24  # episodes of the rhythm
# Episodes of a trained policy, and as many more with other seeds
EPISODES = {"HalfCheetah-v5": 128, "Hopper-v5": 64}
OTHER_SEED = 1000  # seed of the first of the latter


def equations():
    """The cart-pole about the top: rates of cart, pole and their velocities by these, shape (4, 4),
    and by the push on the cart, shape (4, 1)."""
    cart, pole, half, gravity = 1.0, 0.1, 0.5, 9.81  # [kg], [kg], [m], [m/s^2]
    inertia = pole * (2.0 * half) ** 2 / 12.0
    mass = np.array([[cart + pole, pole * half], [pole * half, pole * half**2 + inertia]])
    falls = np.linalg.solve(mass, np.array([[0.0, 0.0], [0.0, pole * gravity * half]]))
    rates = np.block([[np.zeros((2, 2)), np.eye(2)], [falls, np.zeros((2, 2))]])
    return rates, np.concatenate([np.zeros(2), np.linalg.solve(mass, [1.0, 0.0])])[:, None]


def gains():
    """Linear-quadratic gains of the cart-pole, shape (1, 4)."""
    rates, push = equations()
    costs = np.diag([1.0, 10.0, 1.0, 1.0])
    return push.T @ solve_continuous_are(rates, push, costs, np.eye(1))


def continuous_limits():
    """The exact limits of the continuous cart-pole under these gains: the longest hold without a
    delay, the longest delay, and the largest factor of the gains, at the hold of the model."""
    rates, push = equations()

    def flow(time):
        whole = expm(np.block([[rates, push], [np.zeros((1, 5))]]) * time)
        return whole[:4, :4], whole[:4, 4:]

    def stable(hold, delay=0.0, factor=1.0):
        periods, rest = divmod(delay, hold)
        parts = flow(rest), flow(hold - rest)
        return loop_multiplier(*parts, factor * gains(), int(periods)) < 1.0

    hold = 0.01 * HOLD
    limits = {}
    for name, holds, values in (
        ("hold", stable, np.arange(0.001, 2.0, 0.001)),
        ("delay", lambda delay: stable(hold, delay), np.arange(0.0, 1.0, 0.001)),
        ("gain", lambda factor: stable(hold, 0.0, factor), np.arange(1.0, 100.0, 0.05)),
    ):
        limits[name] = first_unstable(holds, values)
    return limits


def cart_pole():
    """The stable intervals of hold, delay and gain of a cart-pole under linear-quadratic gains,
    predicted, and measured by runs: the last value that decays, and the first that grows."""
    factors = gains()

    def balance(time, qpos, qvel):
        return -factors @ np.concatenate([qpos, qvel])

    loops = []
    for name, finer in (("euler", 1), ("implicitfast", 1), ("rk4", 1), ("euler", 10)):
        compiled = mujoco.MjModel.from_xml_path(str(CART_POLE))
        compiled.opt.timestep /= finer
        model = user_models().model(compiled, AS_IT_STANDS).with_integrators((name,))
        loop = ClosedLoop(balance, 1, model.layout.velocity)
        fed_back = FedBackModel(model, loop, HOLD * finer, 0)
        found = loop_record(loop_stability(fed_back, model.state))
        found["measured"] = measured(fed_back, found)
        loops.append(found)
    return {"gains": factors[0].tolist(), "loops": loops, "continuous": continuous_limits()}


def measured(fed_back, found):
    """Whether runs decay at each upper limit and grow a step beyond it; a hundredth inside and
    outside, where that is more than a step."""
    point = np.array(found["state"]), np.array(found["control"])
    linear = fed_back.linear(*point)
    step = fed_back.model.step
    results = {}
    for interval in found["intervals"]:
        quantity = interval["quantity"]
        value = interval["high"]["value"]
        sides = (0.99 * value, 1.01 * value)
        if quantity != "gain":
            last, further = round(value / step), int(0.01 * value / step)
            sides = (last - further, last + 1 + further)
        grown = [fed_back.grows(point, linear.changed(quantity, side)) for side in sides]
        results[quantity] = grown == [False, True]
    return results


class Rhythm:
    """Six joints of the half cheetah driven by sines, with their rates fed back."""

    phases = np.array([0.0, 0.8, 1.6, 3.1, 3.9, 4.7])
    period = 0.05  # [s]

    def __init__(self, feedback):
        self.feedback = feedback

    def reset(self):
        self.calls = 0

    def __call__(self, observation):
        time = self.calls * self.period
        wave = np.sin(2.0 * np.pi * 2.2 * time + self.phases)
        self.calls += 1
        return np.clip(0.9 * wave - self.feedback * observation[11:17], -1.0, 1.0)


class Linear:
    """A trained policy: linear in the observation, and clipped."""

    def __init__(self, task):
        self.weights = np.loadtxt(FOLDER / f"{task}.txt")

    def __call__(self, observation):
        return np.clip(self.weights[:, :-1] @ observation + self.weights[:, -1], -1.0, 1.0)


def returns(task, policy, count, periods, finer, first_seed=0):
    """The mean returns of a task at its file's step, at finer steps, and with RK4 and implicitfast
    at the file's, and the returns of all episodes."""
    made = environment(task)
    start, period = start_and_period(made)
    model = user_models().model(start, AS_IT_STANDS)
    own = round(period / model.step)
    pairs = [(model.integrator, own * n) for n in finer]
    others = {"rk4", "implicitfast"} - {model.integrator}
    pairs += [(name, own) for name in sorted(others, reverse=True)]
    settings = [Setting(name, period / parts, parts) for name, parts in pairs]
    script = Script(model.state, period, np.zeros((periods, model.rest.size)))
    episodes = EnvironmentEpisodes(made.spec, first_seed, policy, model, script)
    outcomes, _ = outcomes_of(episodes, settings, range(count))
    return returns_of(settings, np.array(outcomes), count)


def rows_of(found):
    """The rows of returns as plain data."""
    return [
        {
            "integrator": row.integrator,
            "step": row.step,
            "mean": row.mean.mean,
            "half": row.mean.half,
            "difference": row.difference and row.difference.mean,
            "difference_half": row.difference and row.difference.half,
            "length": row.length,
        }
        for row in found.rows
    ]


def cheetah_rhythm():
    """The return of a half cheetah under a rhythm with feedback, at each step."""
    rows = {
        f"{feedback:g}": rows_of(returns(CHEETAH, Rhythm(feedback), STARTS, 100, FINER))
        for feedback in FEEDBACKS
    }
    return {"starts": STARTS, "rows": rows}


def trained_policies():
    """The return of policies that were trained at the file's step, at other steps, and again with
    other seeds."""
    tasks = {}
    for task, (periods, *_) in TASKS.items():
        first, again = (
            returns(task, Linear(task), EPISODES[task], periods, (1, 4, 16), seed)
            for seed in (0, OTHER_SEED)
        )
        # The difference of both estimates of what the smallest step changes, of independent seeds
        changes = [found.values[:, 2] - found.values[:, 0] for found in (first, again)]
        apart = interval_of(changes[0] - changes[1])
        tasks[task] = {
            "episodes": EPISODES[task],
            "rows": rows_of(first),
            "again": rows_of(again),
            "apart": [apart.low, apart.high],
        }
    return {"tasks": tasks}


COMPUTED = {
    "engines/cart_pole_loop": cart_pole,
    "engines/cheetah_rhythm": cheetah_rhythm,
    "engines/trained_policies": trained_policies,
}


def computed_now(template):
    """The numbers of a template, computed here and now, as they are shipped."""
    made_with = provenance("")
    versions = {package: made_with.versions[package] for package in PACKAGES}
    with quiet():
        numbers = plain(COMPUTED[template](), FOR_TEMPLATES)
    return ExactNumbers(made_with.date.partition(" ")[0], versions, numbers)


def main(names):
    """Write the files of the named templates, or of all."""
    for template in names or COMPUTED:
        file = exact_numbers_file(template)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text_of(computed_now(template)), "utf-8")
        print(file)


if __name__ == "__main__":
    main(sys.argv[1:])
