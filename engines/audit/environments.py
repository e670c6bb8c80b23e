"""Gymnasium's MuJoCo environments: reset with a seed, and rolled out under a policy."""

from __future__ import annotations

import copy
import importlib
import warnings
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.audit.user_models import quiet
from plumbob.engines.own_motion import Policy, periods, policy_name
from plumbob.models.border import must_be
from plumbob.models.entry_points import captured, on_stderr


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


def start_and_period(environment: Any) -> tuple[Any, float]:
    """Returns a copy of the mjData of an environment, and the time [s] for which it holds an
    action."""
    inner = environment.unwrapped
    return copy.copy(inner.data), float(inner.frame_skip * inner.model.opt.timestep)


def rollout(environment: Any, policy: Policy, duration: float) -> Array:
    """Returns the controls, shape (periods, actuators), that an environment computes from the
    actions of `policy`. The policy is called with observations for a duration [s] or until the
    episode ends. Raises ParameterError."""
    name = policy_name(policy)
    what = "a function of an observation that returns actions"
    inner = environment.unwrapped
    controls = list[Array]()
    with must_be(what, "policy", name):
        observation = inner._get_obs()
    with on_stderr(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for _ in range(periods(duration, inner.dt)):
            with must_be(what, "policy", name):
                observation, _, ended, late, _ = environment.step(policy(observation))
                controls.append(np.array(inner.data.ctrl, dtype=float))
            if ended or late:
                break
    if not np.isfinite(controls).all():
        raise ParameterError("policy", name, f"{what}: finite ones")
    return np.array(controls)
