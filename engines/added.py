"""Validates and isolates engines of other packages: their exceptions and output become results."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.known_limits import declared_by
from plumbob.engines.method import Engine, Method, Simulation, Stepping, Unsupported
from plumbob.engines.trajectory import Trajectory, not_a_trajectory
from plumbob.models.border import Refused, border
from plumbob.models.entry_points import Addition, captured
from plumbob.models.scene import Case


def wrong(engine: Any, name: str) -> str:
    """The reason why an object is no engine of this name; empty if it is one."""
    if not isinstance(engine, Engine):
        return f"{type(engine).__name__} in place of a plumbob Engine"
    if why := mistyped(engine):
        return why
    if engine.name != name:
        return f"the engine is called {engine.name!r}, its entry point {name!r}"
    if not engine.methods:
        return "it has no methods"
    reasons = (_wrong_method(method, name) for method in engine.methods)
    return next(filter(None, reasons), "") or wrong_limits(engine)


def mistyped(record: Any) -> str:
    """Names the first field of a dataclass whose value is not of the declared type; empty if there
    is none."""
    for name, kind in get_type_hints(type(record)).items():
        value = getattr(record, name)
        if not _is_of(value, kind):
            return f"{name} of its {type(record).__name__} is {value!r}"
    return ""


def _is_of(value: Any, kind: Any) -> bool:
    """Whether a value is of an annotated type; an int counts as a float."""
    origin = get_origin(kind) or kind
    arguments = get_args(kind)
    if origin in (Union, UnionType):
        return any(_is_of(value, argument) for argument in arguments)
    if origin is Literal:
        return value in arguments
    if origin is tuple and isinstance(value, tuple):
        return all(_is_of(item, arguments[0]) for item in value)
    if origin is float:
        return isinstance(value, (int, float))
    return origin is Any or isinstance(value, origin)


def wrong_limits(engine: Engine) -> str:
    """The reason why an engine's limits, in its file or in Python, are malformed; empty if they are
    well formed."""
    try:
        with border():  # the file belongs to another package: anything may be in it
            limits = declared_by(engine)
    except Refused as error:
        return f"its file of limits: {error}"
    return next(filter(None, map(mistyped, (*limits.known_limits, *limits.not_read))), "")


def _wrong_method(method: Method, engine: str) -> str:
    """The reason why a method is not a valid one of an engine; empty if it is."""
    if why := mistyped(method):
        return why
    if not method.name.startswith(f"{engine}/") or method.name.count("/") != 1:
        return f"the method {method.name!r} is not called {engine}/..."
    if method.control == "tolerance":
        why = "no step_sizes, its tolerances from loose to tight"
        return "" if method.step_sizes else f"{method.name}: {why}"
    if method.order is None or method.order < 1:
        return f"{method.name}: its order is {method.order!r}, not 1 or greater"
    return ""


def guarded(added: Addition) -> Engine:
    """An engine of another package whose exceptions become results. If preparing a scene raises,
    the scene is unsupported; if a run raises, the run has diverged. Printed output becomes a
    warning of the run."""
    engine: Engine = added.found

    def prepare(case: Case, method: Method, step: float) -> Simulation:
        """Prepares a scene; raises Unsupported if the engine raises, or prepares no simulation."""
        simulation = _asked(added, "prepare", lambda: engine.prepare(case, method, step))
        for part in ("run", "stepped"):
            if not callable(getattr(simulation, part, None)):
                raise Unsupported(f"{added.package}: what it prepares has no {part}()")
        return _Guarded(added.package, simulation, _seconds(simulation))

    return replace(
        engine,
        prepare=prepare,
        model_error=lambda *about: _asked(
            added, "model_error", lambda: engine.model_error(*about)
        ),
        optional=True,
        distribution=added.distribution,
    )


def _asked(added: Addition, what: str, ask: Callable[[], Any]) -> Any:
    """Returns what a function of the engine returns. An exception of the function becomes
    Unsupported, with the name of the package and of the function, `what`."""

    def unsupported(line: str) -> Unsupported:
        """The error for an exception of the function, given as one line."""
        return Unsupported(f"{added.package}: {what} raises {line}")

    with border(unsupported, Unsupported, ParameterError), captured():
        return ask()


def _seconds(simulation: Any) -> float:
    """The time that compiling took [s]; 0 if the simulation has no such number."""
    seconds = getattr(simulation, "compile_seconds", 0.0)
    return float(seconds) if isinstance(seconds, (int, float)) else 0.0


@dataclass
class _Guarded:
    """A simulation of another package's engine, whose exceptions become results."""

    package: str
    simulation: Any
    compile_seconds: float

    def run(self) -> Trajectory:
        """Returns the engine's run. If the engine raises, or returns no trajectory, the run counts
        as diverged at the start."""
        with captured() as output:
            try:
                with border():
                    run: Trajectory = self.simulation.run()
                    why = not_a_trajectory(run)
            except Refused as error:
                why = f"run raises {error}"
        if why:
            warning = f"{self.package}: {why}"
            return Trajectory(np.zeros(1), {}, diverged_at=0.0, warnings=(warning,))
        printed = " ".join(output[0].split())
        if not printed:
            return run
        return replace(run, warnings=(*run.warnings, f"{self.package} prints: {printed[:120]}"))

    def stepped(self, fraction: float) -> Stepping:
        """Returns the cost of the steps of the first `fraction` of the run; of no steps if the
        engine raises."""
        try:
            with border(), captured():
                stepping = self.simulation.stepped(fraction)
        except Refused:
            return Stepping(0, 0.0)
        return stepping if isinstance(stepping, Stepping) else Stepping(0, 0.0)
