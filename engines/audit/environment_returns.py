"""The return of an environment's own rewards: on one motion, at the model's step and in its
continuous limit, and in episodes that begin at resets with other seeds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.audit.environments import Rollout, made, reset_to, rollout
from plumbob.engines.audit.mean_returns import Setting
from plumbob.engines.audit.reference import Certificate
from plumbob.engines.closed_loop import (
    OF_OBSERVATION,
    NamedPolicy,
    PolicyAnswers,
    name_of_function,
)
from plumbob.engines.own_motion import MovesData, NotControlled, OwnModel, Policy, Script
from plumbob.engines.stepper import Diverged


@dataclass(frozen=True)
class MotionReturn:
    """The sum of the rewards of an episode: at the model's own step, and of the certified motion as
    far as that is known."""

    own: float  # return of the environment's own rollout, to its end
    duration: float  # [s] duration of the environment's own rollout
    ended: bool  # whether the environment ended it early
    until: float  # [s] time up to which both returns are known
    own_until: float  # return of the environment's own rollout up to `until`
    limit_until: float  # return of the certified motion up to `until`
    uncertainty: float  # difference of `limit_until` between two computations of the motion
    # `own`, less the return of the same states and actions if rewards read all quantities at the
    # end of a step. Quantities that the engine computes at the begin of a step lag by that step.
    lag: float


def motion_return(
    environment: Any,
    policy: Policy | NamedPolicy,
    model: OwnModel,
    script: Script,
    reference: Certificate,
) -> MotionReturn:
    """Returns the return of an environment under a policy from the start of a script, whose
    certified motion in the loop is `reference`. Raises ParameterError for a policy that fails."""
    count = len(script.controls)

    def rolled_out(answer: Any, length: int, move: MovesData | None = None) -> Rollout:
        """Returns the episode from the start of the script, of `length` periods at most."""
        seen = reset_to(environment, script.start, model)
        return rollout(environment, seen, answer, length, move)

    try:
        own = rolled_out(PolicyAnswers(policy, OF_OBSERVATION), count)
    except NotControlled as why:
        wanted = f"{OF_OBSERVATION}; {why}"
        raise ParameterError("policy", name_of_function(policy), wanted) from None
    length = len(own.rewards)
    actions = iter(own.actions)
    anew = rolled_out(lambda seen: next(actions), length, _along(model, own.states))
    known = reference.known
    motions = (reference.course.states, reference.confirmed_by.states)
    limits = [
        rolled_out(
            PolicyAnswers(policy, OF_OBSERVATION), known, _along(model, states[1:])
        ).rewards
        for states in motions
    ]
    until = min(length, *map(len, limits))
    first, second = (float(rewards[:until].sum()) for rewards in limits)
    return MotionReturn(
        own=float(own.rewards.sum()),
        duration=length * script.period,
        ended=length < count,
        until=until * script.period,
        own_until=float(own.rewards[:until].sum()),
        limit_until=first,
        uncertainty=abs(second - first),
        lag=float(own.rewards.sum() - anew.rewards.sum()),
    )


def _along(model: OwnModel, states: Array) -> MovesData:
    """Returns a function that puts an mjData into each of `states`, shape (n, ...), in turn."""
    later = iter(states)
    return lambda data, control: model.place_data(data, next(later))


@dataclass(frozen=True)
class EnvironmentEpisodes:
    """Episodes of an environment under a policy, each from a reset with a seed of its own, from the
    `first_seed` on. `environment` is its specification, or itself if it has none."""

    environment: Any
    first_seed: int
    policy: Policy | NamedPolicy
    model: OwnModel
    script: Script  # its controls are not used

    @cached_property
    def _made(self) -> Any:
        """The environment, made by its specification."""
        return made(self.environment)

    @property
    def names(self) -> tuple[str, ...]:
        """The specification of the environment, the first seed, and the name of the policy."""
        return str(self.environment), str(self.first_seed), name_of_function(self.policy)

    @property
    def shareable(self) -> bool:
        """Whether other processes can make the environment and load the policy."""
        return not hasattr(self.environment, "step") and isinstance(self.policy, NamedPolicy)

    def outcome(self, number: int, setting: Setting) -> tuple[float, float]:
        """Returns the return of an episode at a setting, and its duration [s]; NaN if the run is
        lost. Raises ParameterError."""
        period = self.script.period
        move = self.model.moving_data(setting.integrator, period, setting.parts)
        observation, _ = self._made.reset(seed=self.first_seed + number)
        answers = PolicyAnswers(self.policy, OF_OBSERVATION)
        count = len(self.script.controls)
        try:
            rewards = rollout(self._made, observation, answers, count, move).rewards
        except (Diverged, NotControlled):
            return math.nan, math.nan
        value = float(rewards.sum())
        return (value, len(rewards) * period) if math.isfinite(value) else (math.nan, math.nan)
