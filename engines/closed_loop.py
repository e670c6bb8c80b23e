"""A user's policy in the loop: made anew for each run, and asked with that run's own states."""

from __future__ import annotations

import os
import pkgutil
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any, cast

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.own_motion import NotControlled, Policy, RunControls, policy_name
from plumbob.models.border import must_be, shortened
from plumbob.models.entry_points import on_stderr

# [s] longest time that the answers to one run may take: some thousand answers of a neural network
LONGEST_ANSWERS = 10.0


class _TooSlow(Exception):
    """A policy's answers to one run take more than LONGEST_ANSWERS."""


@dataclass(frozen=True)
class NamedPolicy:
    """A policy MODULE:FUNCTION or MODULE:CLASS; the module may lie in a `folder`. Another process
    can load it, too."""

    name: str
    folder: str

    def load(self) -> Policy:
        """Returns the function or the class. Raises ParameterError."""
        wanted = "MODULE:FUNCTION, a function of time, qpos and qvel"
        return load_function("policy", self.name, self.folder, wanted)


def load_function(option: str, name: str, folder: str, wanted: str) -> Callable[..., Any]:
    """Returns the function or class MODULE:NAME that is given as an `option`; the module may lie in
    a `folder`. Raises ParameterError, which says what is `wanted`."""
    sys.path.insert(0, folder)
    try:
        # The answer alone goes to stdout: whatever the user's module prints goes to stderr.
        with must_be("MODULE:FUNCTION", option, name), on_stderr():
            function = pkgutil.resolve_name(name)
    finally:
        sys.path.remove(folder)
    if not callable(function):
        raise ParameterError(option, name, wanted)
    return cast(Callable[..., Any], function)


def load_policy(name: str) -> NamedPolicy:
    """Returns the policy MODULE:FUNCTION or MODULE:CLASS, which is loaded once as a check; the
    module may lie in the current folder. Raises ParameterError."""
    policy = NamedPolicy(name, os.getcwd())
    policy.load()
    return policy


def name_of_policy(policy: Policy | NamedPolicy) -> str:
    """Returns the name of a policy in messages."""
    return policy.name if isinstance(policy, NamedPolicy) else policy_name(policy)


def new_policy(policy: Policy | NamedPolicy) -> Policy:
    """Returns a policy for a new run: a class is made anew, and an object's `reset()` is called.
    Raises ParameterError."""
    name = name_of_policy(policy)
    loaded: Any = policy.load() if isinstance(policy, NamedPolicy) else policy
    with must_be("a function, or a class without arguments", "policy", name), on_stderr():
        if isinstance(loaded, type):
            loaded = loaded()
        reset = getattr(loaded, "reset", None)
        if callable(reset):
            reset()
    if not callable(loaded):
        raise ParameterError("policy", name, "a class whose objects are called with a state")
    return cast(Policy, loaded)


@dataclass(frozen=True)
class ClosedLoop:
    """A policy that returns `count` controls for a time [s], positions and velocities, the last at
    the place `velocities` in a state."""

    policy: Policy | NamedPolicy
    count: int
    velocities: slice

    @property
    def name(self) -> str:
        """The name of the policy in messages."""
        return name_of_policy(self.policy)

    def new_run(self) -> RunControls:
        """Returns the controls of a new run, as a function of the time [s] and the state, shape
        (n,). A class is made anew, and an object's `reset()` is called first. The function raises
        ParameterError if the policy fails or takes too long, and NotControlled if it returns a
        number that is not finite."""
        policy = new_policy(self.policy)
        left = LONGEST_ANSWERS

        def control(at: float, state: Array) -> Array:
            """Returns the controls at a time [s] in a state, shape (count,)."""
            nonlocal left
            qpos, qvel = state[: self.velocities.start].copy(), state[self.velocities].copy()
            begin = time.perf_counter()
            try:
                with on_stderr(), _at_most(left):
                    answer = self._checked(policy, (at, qpos, qvel))
                left -= time.perf_counter() - begin
                if left <= 0.0:
                    raise _TooSlow
            except _TooSlow:
                wanted = f"one whose answers to a run take at most {LONGEST_ANSWERS:g} s"
                raise ParameterError("policy", self.name, wanted) from None
            if not np.isfinite(answer).all():
                raise NotControlled(
                    f"the policy returns {shortened(str(answer.tolist()), 40)} at {at:.4g} s"
                )
            return answer

        return control

    def _checked(self, policy: Policy, arguments: tuple[float, Array, Array]) -> Array:
        """Returns what a policy answers, shape (count,), finite or not. Raises ParameterError."""
        wanted = f"a function of time, qpos and qvel that returns {self.count} finite numbers"
        with must_be(wanted, "policy", self.name):
            control = np.asarray(policy(*arguments), dtype=float).reshape(-1)
        if control.shape != (self.count,):
            answer = shortened(str(control.tolist()))
            raise ParameterError("policy", self.name, f"{wanted}, not {answer}")
        return control

    def check_memory(self, times: Array, states: Array, controls: Array) -> None:
        """Raises ParameterError unless the policy, made anew, gives the `controls` of a run again,
        shape (n, count), at the same `times` [s] and states, shape (n, k)."""
        ask = self.new_run()
        for at, state, before in zip(times.tolist(), states, controls, strict=True):
            if not np.array_equal(ask(at, state), before):
                wanted = (
                    "a function of time, qpos and qvel alone, or a class, which is made anew for "
                    f"each run; asked again at {at:.4g} s, it answers otherwise"
                )
                raise ParameterError("policy", self.name, wanted)


@contextmanager
def _at_most(seconds: float) -> Iterator[None]:
    """Raises _TooSlow in the block after so many seconds of wall time. Where no timer can interrupt
    the block, as on Windows and outside the main thread, the block runs to its end."""
    main = threading.current_thread() is threading.main_thread()
    if not (main and hasattr(signal, "setitimer")):
        yield
        return

    def too_slow(number: int, frame: FrameType | None) -> None:
        """Interrupts the block."""
        raise _TooSlow

    handler = signal.signal(signal.SIGALRM, too_slow)
    before = signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, *before)
        signal.signal(signal.SIGALRM, handler)
