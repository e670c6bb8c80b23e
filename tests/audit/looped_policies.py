"""Policies for audits in the loop: two that work, one with a memory, and hostile ones."""

import time as clock

import numpy as np

# gains of a linear-quadratic regulator for the cart-pole
GAINS = np.array([-1.0, -29.0, -2.2, -7.0])
CALLS = []


def balance(time, qpos, qvel):
    """Holds the cart-pole upright, by linear-quadratic gains."""
    return [-GAINS @ np.concatenate([qpos, qvel])]


def swing_up(time, qpos, qvel):
    """Swings a pendulum up, by energy shaping."""
    energy = 0.13 * qvel[0] ** 2 - 4.905 * (np.cos(qpos[0]) + 1.0)
    return [np.clip(-2.0 * energy * qvel[0], -1.5, 1.5)]


def rocks(time, qpos, qvel):
    return [2.0 * np.sin(5.0 * time)]


class Integrates:
    """Balances, with the sum of the angles since it was reset: without reset() it fails."""

    def reset(self):
        self.total = 0.0

    def __call__(self, time, qpos, qvel):
        self.total += 0.01 * qpos[1]
        return [balance(time, qpos, qvel)[0] + 5.0 * self.total]


def jumps(time, qpos, qvel):
    return [np.sign(np.sin(1e11 * qpos[0] + 1.0))]


def raises(time, qpos, qvel):
    raise KeyError("nothing")


def not_a_number(time, qpos, qvel):
    return [np.nan]


def pushes_beyond_mujoco(time, qpos, qvel):
    return [1e11]


def later_not_a_number(time, qpos, qvel):
    """Gives a number to the run that is recorded, which is at this angle only there."""
    return [np.nan if time > 0.05 and abs(qpos[1] - KEPT.setdefault(time, qpos[1])) else 0.0]


KEPT = {}


def two_numbers(time, qpos, qvel):
    return [1.0, 2.0]


def sleeps(time, qpos, qvel):
    clock.sleep(100.0)


def leaves(time, qpos, qvel):
    raise SystemExit(0)


def keeps_state(time, qpos, qvel):
    CALLS.append(time)
    return [1e-3 * len(CALLS)]


class NeedsArguments:
    def __init__(self, number):
        self.number = number


not_callable = 3


def mean_angle(times, qpos, qvel, controls):
    """A metric: the mean angle of the pole at the ends of the periods."""
    return qpos[:, 1].mean()


def no_number(times, qpos, qvel, controls):
    return np.nan


# Policies of observations, for environments

STEERING = 3.0


def steers(observation):
    """Holds an inverted pendulum upright, for a while."""
    return np.clip([STEERING * observation[1] + 0.5 * observation[0]], -3.0, 3.0)


def falls(observation):
    return [0.3]


def raises_at_observation(observation):
    raise KeyError("nothing")


def no_number_at_observation(observation):
    return [np.nan]


def three_actions(observation):
    return [0.0, 0.0, 0.0]


def sleeps_at_observation(observation):
    clock.sleep(100.0)


def leaves_at_observation(observation):
    raise SystemExit(0)


def counts_observations(observation):
    CALLS.append(observation)
    return [1e-3 * len(CALLS)]


# Policies of a joint, for stability about a fixed point

GAINS_OF_JOINT = [15.0, 2.0]  # [N m/rad], [N m s/rad]


def holds_joint(time, qpos, qvel):
    return -(GAINS_OF_JOINT[0] * qpos + GAINS_OF_JOINT[1] * qvel)


class KnowsItsJacobian:
    scale = 1.0

    def __call__(self, time, qpos, qvel):
        return holds_joint(time, qpos, qvel)

    def jacobian(self, time, qpos, qvel):
        return -self.scale * np.array([GAINS_OF_JOINT])


class ExaggeratesItsJacobian(KnowsItsJacobian):
    scale = 2.0


class HasNoGoodJacobian(KnowsItsJacobian):
    def jacobian(self, time, qpos, qvel):
        return [1.0, 2.0, 3.0]


def pushes_away(time, qpos, qvel):
    return 5.0 * qpos


def pushes_always(time, qpos, qvel):
    return [1.0 + qpos[0] ** 2]


def rocks_joint(time, qpos, qvel):
    return [np.sin(time) - qpos[0]]


def steps_at_zero(time, qpos, qvel):
    return -np.sqrt(np.abs(qpos)) * np.sign(qpos) - qvel
