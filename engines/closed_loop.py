"""A user's policy in the loop: made anew for each run, and asked with that run's own states."""

from __future__ import annotations

import os
import pkgutil
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from types import FrameType
from typing import Any, ClassVar, cast

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.own_motion import NotControlled, Policy, RunControls, policy_name
from plumbob.models.border import must_be, shortened
from plumbob.models.entry_points import on_stderr

# [s] longest time that the answers to one run may take: some thousand answers of a neural network
LONGEST_ANSWERS = 10.0
# MuJoCo applies none of the controls if one of them is larger.
LARGEST_CONTROL = 1e10
# A policy that an environment asks, in messages
OF_OBSERVATION = "a function of an observation that returns an action of finite numbers"


class _TooSlow(Exception):
    """A policy's answers to one run take more than LONGEST_ANSWERS."""


@dataclass(frozen=True)
class NamedFunction:
    """A function or a class MODULE:NAME; the module may lie in a `folder`. Another process can load
    it, too."""

    name: str
    folder: str
    option: ClassVar[str]  # by which a user gives it
    wanted: ClassVar[str]  # in messages: what it must be

    def load(self) -> Callable[..., Any]:
        """Returns the function or the class. Raises ParameterError."""
        return load_function(self.option, self.name, self.folder, self.wanted)


class NamedPolicy(NamedFunction):
    """A policy MODULE:FUNCTION or MODULE:CLASS."""

    option = "policy"
    wanted = "MODULE:FUNCTION, a function of time, qpos and qvel"


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


def name_of_function(function: Callable[..., Any] | NamedFunction) -> str:
    """Returns the name of a policy or a metric in messages."""
    return function.name if isinstance(function, NamedFunction) else policy_name(function)


def new_policy(policy: Policy | NamedPolicy) -> Policy:
    """Returns a policy for a new run: a class is made anew, and an object's `reset()` is called.
    Raises ParameterError."""
    name = name_of_function(policy)
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


class PolicyAnswers:
    """The answers of a policy, made anew, to one run. They may take LONGEST_ANSWERS together."""

    def __init__(self, policy: Policy | NamedPolicy, wanted: str) -> None:
        """Raises ParameterError. `wanted` says in messages what the policy must be."""
        self.name, self.wanted = name_of_function(policy), wanted
        self._policy = new_policy(policy)
        self._left = LONGEST_ANSWERS
        self._asked_at: float | None = None  # [s] when the present answer was asked for
        self._watched = False

    def __call__(self, *arguments: Any) -> Any:
        """Returns the answer to arguments. Raises ParameterError if the policy fails or takes too
        long."""
        watch = nullcontext() if self._watched else self.watched()
        try:
            with watch, must_be(self.wanted, "policy", self.name):
                self._asked_at = begin = time.perf_counter()
                answer = self._policy(*arguments)
                self._left -= time.perf_counter() - begin
            if self._left <= 0.0:
                raise _TooSlow
        except _TooSlow:
            wanted = f"one whose answers to a run take at most {LONGEST_ANSWERS:g} s"
            raise ParameterError("policy", self.name, wanted) from None
        finally:
            self._asked_at = None
        return answer

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Interrupts an answer within the block that takes too long. Where no timer can interrupt
        it, as on Windows and outside the main thread, an answer goes on to its end. A block around
        many answers saves most of the time that a block around each takes."""
        main = threading.current_thread() is threading.main_thread()
        if not (main and hasattr(signal, "setitimer")):
            yield
            return
        handler = signal.signal(signal.SIGALRM, self._time_is_over)
        before = signal.setitimer(signal.ITIMER_REAL, self._left)
        self._watched = True
        try:
            yield
        finally:
            self._watched = False
            signal.setitimer(signal.ITIMER_REAL, *before)
            signal.signal(signal.SIGALRM, handler)

    def _time_is_over(self, number: int, frame: FrameType | None) -> None:
        """Raises _TooSlow if the present answer takes too long; else sets the timer anew, since
        time between answers does not count."""
        left = self._left
        if self._asked_at is not None:
            left -= time.perf_counter() - self._asked_at
            if left <= 0.0:
                raise _TooSlow
        signal.setitimer(signal.ITIMER_REAL, left)


AsksPolicy = Callable[[PolicyAnswers, float, Array], Any]
"""PolicyAnswers of a policy, a time [s] and a state, shape (n,) -> the controls at that time."""


@dataclass(frozen=True)
class ClosedLoop:
    """A policy that is asked for `count` controls in the states of a run, whose velocities have the
    place `velocities`. An environment has its own way to ask (`ask`) for an action; else the policy
    is a function of time [s], positions and velocities."""

    policy: Policy | NamedPolicy
    count: int
    velocities: slice
    ask: AsksPolicy | None = None

    @property
    def name(self) -> str:
        """The name of the policy in messages."""
        return name_of_function(self.policy)

    @property
    def wanted(self) -> str:
        """A description of the policy that is expected, for messages."""
        if self.ask is not None:
            return OF_OBSERVATION
        return f"a function of time, qpos and qvel that returns {self.count} finite numbers"

    def new_run(self) -> RunControls:
        """Returns the controls of a new run, as a function of the time [s] and the state, shape
        (n,). A class is made anew, and an object's `reset()` is called first. The function raises
        ParameterError if the policy fails or takes too long, and NotControlled if it returns a
        number that is not finite."""
        answers = PolicyAnswers(self.policy, self.wanted)
        ask = self.ask or self._asked_with_state

        def control(at: float, state: Array) -> Array:
            """Returns the controls at a time [s] in a state, shape (count,)."""
            with on_stderr():
                answer = ask(answers, at, state)
            return finite_controls(self._checked(answer), at)

        return control

    def _asked_with_state(self, answers: PolicyAnswers, at: float, state: Array) -> Any:
        """Returns the answer to a time [s] and the positions and velocities of a state."""
        return answers(at, state[: self.velocities.start].copy(), state[self.velocities].copy())

    def _checked(self, answer: Any) -> Array:
        """Returns an answer as numbers, shape (count,), finite or not. Raises ParameterError."""
        with must_be(self.wanted, "policy", self.name):
            control = np.asarray(answer, dtype=float).reshape(-1)
        if control.shape != (self.count,):
            given = shortened(str(control.tolist()))
            raise ParameterError("policy", self.name, f"{self.wanted}, not {given}")
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


def finite_controls(control: Array, at: float) -> Array:
    """Returns controls at a time [s], shape (n,). Raises NotControlled unless all are finite, and
    at most LARGEST_CONTROL."""
    if not (np.abs(control) <= LARGEST_CONTROL).all():
        beyond = f", beyond {LARGEST_CONTROL:g}" if np.isfinite(control).all() else ""
        returned = shortened(str(control.tolist()), 40)
        raise NotControlled(f"the policy returns {returned} at {at:.4g} s{beyond}")
    return control
