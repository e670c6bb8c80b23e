"""Validates and isolates engines of other packages: their errors and output become results."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.schemes import Scheme
from plumbob.engines.known_limits import Limits, declared_by
from plumbob.engines.method import (
    LIMITS,
    Engine,
    KnownLimit,
    Method,
    Simulation,
    Stepping,
    Unsupported,
    fits,
)
from plumbob.engines.trajectory import Trajectory, not_a_trajectory
from plumbob.models.entry_points import Addition, captured
from plumbob.models.scene import Case


def wrong(engine: Any, name: str) -> str:
    """The reason why an object is no engine of this name; empty where it is one."""
    if not isinstance(engine, Engine):
        return f"{type(engine).__name__} in place of a plumbob Engine"
    if engine.name != name:
        return f"the engine is called {engine.name!r}, its entry point {name!r}"
    if not engine.methods:
        return "it has no methods"
    for method in engine.methods:
        if why := _wrong_method(method, name):
            return why
    for part in ("prepare", "model_error"):
        if not callable(getattr(engine, part)):
            return f"its {part} is no function"
    if not (isinstance(engine.package, str) and engine.package):
        return "its package is no name of a package"
    if not isinstance(engine.abilities, tuple):
        return f"abilities is {type(engine.abilities).__name__}, not a tuple"
    return wrong_limits(engine)


def wrong_limits(engine: Engine) -> str:
    """The reason why an engine's limits, in its file or in Python, are none; empty where they
    are."""
    if not isinstance(engine.known_limits, tuple):
        return f"known_limits is {type(engine.known_limits).__name__}, not a tuple of KnownLimit"
    try:
        limits = declared_by(engine)
    except Exception as error:  # whatever stands in that file
        return f"its file of limits: {one_line(error)}"
    for entry in limits.not_read:
        if not isinstance(entry.observables, tuple):
            return f"observables that it does not give are {entry.observables!r}, not a list"
    names = [method.name for method in engine.methods]
    several = (_wrong_limit(limit, names, limits) for limit in limits.known_limits)
    return next(filter(None, several), "")


def _wrong_limit(limit: Any, methods: Sequence[str], limits: Limits) -> str:
    if not isinstance(limit, KnownLimit):
        return f"{type(limit).__name__} in place of a plumbob KnownLimit"
    of = [name for name in methods if fits(name, limit.methods)]
    if not of:
        return f"a known limit is of {limit.methods!r}, which is none of its methods"
    if limit.verdict not in LIMITS:
        return f"{of[0]}: a known limit is {limit.verdict!r}, not one of {', '.join(LIMITS)}"
    if limit.other not in (None, "predicted", *LIMITS):
        return f"{of[0]}: another verdict is {limit.other!r}, not one of {', '.join(LIMITS)}"
    if not (isinstance(limit.reason, str) and limit.reason.strip()):
        return f"{of[0]}: a known limit has no reason"
    if limit.verdict in ("unsupported", "converges") or any(m in of for _, m in limits.sizes):
        return ""
    numeric = isinstance(limit.size, (int, float)) and math.isfinite(limit.size)
    if not (numeric and limit.size > 0.0):
        return f"{of[0]}: the size of a known limit is {limit.size!r}, not above 0"
    return ""


def _wrong_method(method: Any, engine: str) -> str:
    if not isinstance(method, Method):
        return f"{type(method).__name__} in place of a plumbob Method"
    if not method.name.startswith(f"{engine}/") or method.name.count("/") != 1:
        return f"the method {method.name!r} is not called {engine}/..."
    if not isinstance(method.scheme, Scheme):
        return f"{method.name}: its scheme is {type(method.scheme).__name__}, not a Scheme"
    if method.control not in ("step", "tolerance"):
        return f"{method.name}: control is {method.control!r}, not 'step' or 'tolerance'"
    if method.control == "tolerance" and not method.step_sizes:
        return f"{method.name}: no step_sizes, its tolerances from loose to tight"
    fixed = method.control == "step"
    if fixed and not (isinstance(method.order, int) and method.order > 0):
        return f"{method.name}: its order is {method.order!r}, not 1 or greater"
    if not isinstance(method.systems, tuple):
        return f"{method.name}: systems is {type(method.systems).__name__}, not a tuple of patterns"
    return ""


def guarded(added: Addition) -> Engine:
    """An engine that a package adds, whose errors are results: of preparing, as unsupported, of
    running, as a run that diverged; what it prints is a warning of the run."""
    engine: Engine = added.found

    def prepare(case: Case, method: Method, step: float) -> Simulation:
        simulation = _asked(added, "prepare", lambda: engine.prepare(case, method, step))
        for part in ("run", "stepped"):
            if not callable(getattr(simulation, part, None)):
                raise Unsupported(f"{added.package}: what it prepares has no {part}()")
        return _Guarded(added.package, simulation, _seconds(simulation))

    return replace(
        engine,
        prepare=prepare,
        model_error=lambda *about: _asked(added, "model_error", lambda: engine.model_error(*about)),
        optional=True,
        distribution=added.distribution,
    )


def _asked(added: Addition, what: str, ask: Callable[[], Any]) -> Any:
    """Calls a function of the engine; its errors are raised as Unsupported, with the package's
    name."""
    try:
        with captured():
            return ask()
    except (Unsupported, ParameterError):
        raise
    except (Exception, SystemExit) as error:
        raise Unsupported(f"{added.package}: {what} raises {one_line(error)}") from error


def _seconds(simulation: Any) -> float:
    seconds = getattr(simulation, "compile_seconds", 0.0)
    return float(seconds) if isinstance(seconds, (int, float)) else 0.0


@dataclass
class _Guarded:
    """A simulation of a package's engine; what goes wrong in it becomes a result."""

    package: str
    simulation: Any
    compile_seconds: float

    def run(self) -> Trajectory:
        """The engine's run; one that raises, or is no trajectory, counts as diverged at once."""
        with captured() as output:
            try:
                run: Trajectory = self.simulation.run()
                why = not_a_trajectory(run)
            except (Exception, SystemExit) as error:
                why = f"run raises {one_line(error)}"
        if why:
            said_why = (f"{self.package}: {why}",)
            return Trajectory(np.zeros(1), {}, diverged_at=0.0, warnings=said_why)
        printed = " ".join(output[0].split())
        if not printed:
            return run
        return replace(run, warnings=(*run.warnings, f"{self.package} prints: {printed[:120]}"))

    def stepped(self, fraction: float) -> Stepping:
        """The steps of the first `fraction`; none count where the engine raises."""
        try:
            with captured():
                stepping = self.simulation.stepped(fraction)
        except (Exception, SystemExit):
            return Stepping(0, 0.0)
        return stepping if isinstance(stepping, Stepping) else Stepping(0, 0.0)


def one_line(error: BaseException) -> str:
    """An error of another package, in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())[:160]
