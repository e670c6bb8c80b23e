"""Gymnasium's MuJoCo environments: reset with a seed, and rolled out under a policy. Whatever moves
the state of an environment, its own code makes observations, controls and rewards."""

from __future__ import annotations

import copy
import importlib
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.audit.user_models import quiet
from plumbob.engines.closed_loop import OF_OBSERVATION, PolicyAnswers, finite_controls
from plumbob.engines.own_motion import MovesData, NotControlled, OwnModel
from plumbob.engines.stepper import Diverged
from plumbob.models.border import must_be
from plumbob.models.entry_points import captured, on_stderr

STEPS_ELSEWHERE = "one that calls MujocoEnv.do_simulation once an action"


def environment(name: str, seed: int = 0) -> Any:
    """Returns the environment of that name in Gymnasium, reset with a seed. Raises ImportError if
    Gymnasium, or a package that it needs, is not installed, and ParameterError if it has no such
    MuJoCo environment."""
    gymnasium = importlib.import_module("gymnasium")
    what = "the name of a MuJoCo environment of Gymnasium"
    at_border = must_be(what, "gym", name, ImportError)
    with at_border, quiet(), captured(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = gymnasium.make(name)
        result.reset(seed=seed)
        of_mujoco = hasattr(result.unwrapped, "frame_skip")
    if not of_mujoco:
        raise ParameterError("gym", name, what)
    return result


def made(specified: Any) -> Any:
    """Returns the environment of a specification of Gymnasium; an environment as it is."""
    if hasattr(specified, "step"):
        return specified
    with captured(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return importlib.import_module("gymnasium").make(specified)


def start_and_period(environment: Any) -> tuple[Any, float]:
    """Returns a copy of the mjData of an environment, and the time [s] for which it holds an
    action."""
    inner = environment.unwrapped
    return copy.copy(inner.data), float(inner.frame_skip * inner.model.opt.timestep)


def state_in(data: Any) -> Array:
    """Returns the state of an environment's mjData: qpos, qvel and act, shape (n,)."""
    return np.concatenate([data.qpos, data.qvel, data.act])


@dataclass(frozen=True)
class Rollout:
    """An episode of an environment, up to its end or to the longest length allowed."""

    controls: Array  # shape (periods, actuators)
    rewards: Array  # shape (periods,)
    actions: tuple[Any, ...]
    states: Array  # qpos, qvel and act at the ends of the periods, shape (periods, n)


def rollout(
    environment: Any,
    observation: Any,
    answer: Callable[[Any], Any],
    count: int,
    move: MovesData | None = None,
) -> Rollout:
    """Returns an episode of an environment that has been reset, of `count` periods at most, from an
    `observation` of its state on. `answer` gives the action for an observation. In place of the
    environment's simulator `move`, if given, moves its mjData through each period. Raises
    ParameterError, NotControlled for controls that are not finite, and Diverged as `move` does."""
    data = environment.unwrapped.data
    rewards = list[float]()
    actions = list[Any]()
    states = list[Array]()
    name = getattr(answer, "name", "policy")
    watch = answer.watched() if isinstance(answer, PolicyAnswers) else nullcontext()
    moved = _moved(environment.unwrapped, move)
    with moved as controls, on_stderr(), watch, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for _ in range(count):
            actions.append(answer(observation))
            with must_be(OF_OBSERVATION, "policy", name, Diverged, NotControlled):
                observation, reward, ended, late, _ = environment.step(actions[-1])
                rewards.append(float(reward))
            states.append(state_in(data))
            if len(controls) != len(rewards):
                kind = type(environment.unwrapped).__name__
                raise ParameterError("gym", kind, STEPS_ELSEWHERE)
            if ended or late:
                break
    return Rollout(np.array(controls), np.array(rewards), tuple(actions), np.array(states))


@contextmanager
def _moved(inner: Any, move: MovesData | None) -> Iterator[list[Array]]:
    """Yields the controls of each period that an environment simulates within the block, each of
    shape (actuators,). `move` replaces the simulator, if given."""
    controls = list[Array]()
    simulate = inner._step_mujoco_simulation

    def simulated(control: Any, frames: int) -> None:
        """Moves the environment's state through a period."""
        checked = finite_controls(np.array(control, dtype=float), float(inner.data.time))
        controls.append(checked)
        if move is None:
            simulate(control, frames)
        else:
            move(inner.data, checked)

    inner._step_mujoco_simulation = simulated
    try:
        yield controls
    finally:
        del inner._step_mujoco_simulation


def observed(environment: Any) -> Any:
    """Returns the observation of the present state of an environment, as its wrappers change it."""
    wrappers = list[Any]()
    while environment is not environment.unwrapped:
        wrappers.append(environment)
        environment = environment.env
    observation = environment._get_obs()
    for wrapper in reversed(wrappers):
        if hasattr(wrapper, "observation"):
            observation = wrapper.observation(observation)
    return observation


def reset_to(environment: Any, state: Array, model: OwnModel) -> Any:
    """Resets an environment, with the seed of its last reset, and puts it into a state of its model
    unless it is there. Returns the observation."""
    observation, _ = environment.reset(seed=max(0, environment.unwrapped.np_random_seed))
    data = environment.unwrapped.data
    if np.array_equal(state_in(data), state):
        return observation
    model.place_data(data, state)
    return observed(environment)


@dataclass(frozen=True)
class AskedEnvironment:
    """Asks a policy in any state of an environment, whose code makes the observation of the state
    and the controls of the action."""

    environment: Any
    model: OwnModel

    def __call__(self, answers: PolicyAnswers, at: float, state: Array) -> Array:
        """Returns the controls, shape (actuators,), at a time [s] in a state, shape (n,)."""
        data = self.environment.unwrapped.data
        self.model.place_data(data, state)
        data.time = at
        seen = observed(self.environment)
        asked = rollout(self.environment, seen, answers, 1, lambda *moved: None)
        return np.asarray(asked.controls[0])
