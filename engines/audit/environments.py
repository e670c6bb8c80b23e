"""Gymnasium's MuJoCo environments: reset with a seed, and rolled out under a policy."""

from __future__ import annotations

import copy
import importlib
import warnings
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.added import one_line
from plumbob.engines.audit.user_models import quiet
from plumbob.engines.own_motion import Policy, periods
from plumbob.models.entry_points import captured, on_stderr


def environment(name: str, seed: int = 0) -> Any:
    """The environment of that name in Gymnasium, reset with a seed; raises ImportError where
    Gymnasium, or what it needs, is not installed, and ParameterError where it has no such MuJoCo
    environment."""
    gymnasium = importlib.import_module("gymnasium")
    what = "the name of a MuJoCo environment of Gymnasium"
    try:
        with quiet(), captured(), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = gymnasium.make(name)
            result.reset(seed=seed)
    except ImportError:
        raise
    except Exception as error:  # of the environment's own, too
        raise ParameterError("gym", name, f"{what} ({error})") from None
    if not hasattr(result.unwrapped, "frame_skip"):
        raise ParameterError("gym", name, what)
    return result


def start_and_period(environment: Any) -> tuple[Any, float]:
    """A copy of the mjData of an environment, and for how long [s] it holds an action."""
    inner = environment.unwrapped
    return copy.copy(inner.data), float(inner.frame_skip * inner.model.opt.timestep)


def rollout(environment: Any, policy: Policy, duration: float) -> Array:
    """Controls, shape (periods, actuators), that an environment makes of the actions of `policy`,
    which is called with its observations, for a duration [s] or until the episode ends. Raises
    ParameterError."""
    inner = environment.unwrapped
    controls = list[Array]()
    observation = inner._get_obs()
    name = getattr(policy, "__name__", type(policy).__name__)
    with on_stderr(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for _ in range(periods(duration, inner.dt)):
            try:
                observation, _, ended, late, _ = environment.step(policy(observation))
            except (Exception, SystemExit) as error:
                what = (
                    f"a function of an observation that returns an action ({one_line(error)})"
                )
                raise ParameterError("policy", name, what) from None
            controls.append(np.array(inner.data.ctrl))
            if ended or late:
                break
    if not np.isfinite(controls).all():
        raise ParameterError("policy", name, "a function of an observation: finite actions")
    return np.array(controls)
