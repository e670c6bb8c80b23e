"""The engines: modules of `adapters` with an ENGINE, and those that other installed packages add by
entry points of the group `plumbob.engines`; and their builders of systems."""

from __future__ import annotations

import fnmatch
import importlib.util
import pkgutil
from collections.abc import Iterable, Mapping
from functools import cache
from importlib import import_module
from importlib.machinery import PathFinder
from pathlib import Path
from types import ModuleType

from plumbob.analytic.parameters import ParameterError
from plumbob.engines import added
from plumbob.engines.known_limits import Limits, declared_by
from plumbob.engines.method import Engine, Method, ModelError, Unsupported
from plumbob.models import entry_points
from plumbob.models.registry import unknown
from plumbob.models.scene import SMOOTH, Case, System

_ADAPTERS = "plumbob.engines.adapters"


@cache
def built_in() -> Mapping[str, Engine]:
    """The engines that plumbob has adapters for, in the order of their names, installed or not."""
    adapters = [
        getattr(import_module(f"{_ADAPTERS}.{module.name}"), "ENGINE", None)
        for module in pkgutil.iter_modules([str(Path(__file__).parent / "adapters")])
    ]
    return {e.name: e for e in sorted(filter(None, adapters), key=lambda engine: engine.name)}


@cache
def engines() -> Mapping[str, Engine]:
    """All engines by name, in the order of their names, installed or not; those of other packages
    among them, whose modules are loaded for it."""
    every = dict(built_in())
    for name in entry_points.points(entry_points.ENGINES):
        if (engine := _added(name)) is not None:
            every.setdefault(name, engine)
    return {name: every[name] for name in sorted(every)}


def find_engine(name: str) -> Engine:
    """The engine of this name; no package is loaded that adds another. Raises ParameterError."""
    if name in built_in():
        return built_in()[name]
    if (engine := _added(name)) is not None:
        return engine
    raise ParameterError("engine", name, broken(name) or f"one of {', '.join(engines())}")


def limits_of(method: str) -> Limits:
    """The limits of the engine of a method, by the method's name; none of a stored study's engine
    that is no longer there."""
    try:
        return declared_by(find_engine(method.partition("/")[0]))
    except ParameterError:
        return Limits()


def unguarded(name: str) -> Engine:
    """The engine of this name as its package gives it, whose errors are raised and whose output is
    seen; raises ParameterError."""
    engine = find_engine(name)
    if not engine.distribution:
        return engine
    adapter: Engine = entry_points.addition(entry_points.ENGINES, name, _wrong).found
    return adapter


def broken(name: str) -> str:
    """The requirement on an engine's name where a package that adds it cannot be used; else
    empty."""
    if name in built_in() or name not in entry_points.points(entry_points.ENGINES):
        return ""
    adds = entry_points.addition(entry_points.ENGINES, name, _wrong)
    return f"of an engine that can be used; {adds.package}: {adds.reason}" if adds.reason else ""


@cache
def _added(name: str) -> Engine | None:
    """The engine that another package adds under this name; None where there is none, or it is
    broken."""
    if name not in entry_points.points(entry_points.ENGINES):
        return None
    entry = entry_points.addition(entry_points.ENGINES, name, _wrong)
    return None if entry.reason else added.guarded(entry)


def _wrong(engine: object, name: str) -> str:
    if name in built_in():
        return f"plumbob has an engine called {name!r} itself"
    return added.wrong(engine, name)


def installed(engine: Engine) -> bool:
    """Whether the engine's package is there; a package inside another is looked for without
    importing that one."""
    outer, _, inner = engine.package.rpartition(".")
    spec = importlib.util.find_spec(outer or inner)
    if spec is None or not outer:
        return spec is not None
    return PathFinder.find_spec(inner, spec.submodule_search_locations) is not None


def _of(pattern: str) -> Iterable[Engine]:
    """The engines that one part of a pattern can mean: one where it names one, otherwise all."""
    name = pattern.partition("/")[0]
    if name in built_in():
        return (built_in()[name],)
    if name in entry_points.points(entry_points.ENGINES):
        return filter(None, (_added(name),))
    return engines().values()


def methods(pattern: str = "*") -> tuple[Method, ...]:
    """Methods whose name, or engine, matches the shell pattern (several with commas), installed or
    not; raises ParameterError when one part of the pattern matches none."""
    wanted = pattern.split(",")
    of = {engine.name: engine for part in wanted for engine in _of(part)}
    every = [method for name in sorted(of) for method in of[name].methods]
    for part in wanted:
        if not any(_matches(method, part) for method in every):
            raise ParameterError("methods", part, _one_of(part))
    return tuple(m for m in every if any(_matches(m, part) for part in wanted))


def method(name: str) -> Method:
    """The method `engine/name`; raises ParameterError when there is none."""
    for engine in _of(name):
        for candidate in engine.methods:
            if candidate.name == name:
                return candidate
    raise ParameterError("method", name, _one_of(name))


def _one_of(name: str) -> str:
    """The requirement on a method's name: the names there are, or why one cannot be used."""
    every = [method.name for engine in engines().values() for method in engine.methods]
    return broken(name.partition("/")[0]) or unknown(name, every)


def engine_of(method: Method) -> Engine:
    """The engine that a method belongs to; raises ParameterError where it is no longer there."""
    return find_engine(method.engine)


def _matches(method: Method, pattern: str) -> bool:
    return fnmatch.fnmatchcase(method.name, pattern) or method.engine == pattern


def find_builder(engine: str, system: System) -> ModuleType:
    """The module that builds `system` in an engine, `adapters/<engine>/<family>.py` or what the
    system names, or of smooth degrees of freedom the one for all; raises Unsupported when there is
    none."""
    every = (system.family, "smooth_system") if system.kind == SMOOTH else (system.family,)
    names = [f"{_ADAPTERS}.{engine}.{module}" for module in every]
    for name in (system.builders[engine],) if engine in system.builders else names:
        try:
            return import_module(name)
        except ModuleNotFoundError as error:
            if error.name != name:
                raise
    raise Unsupported(f"{engine} has no builder for {system.name}")


def model_error(case: Case, method: Method, step: float, engine: str = "") -> ModelError:
    """Bounds on what a builder's model adds to each observable, by reason, in the method's engine
    unless another is named: none where it has no `model_error`; raises Unsupported."""
    builder = find_builder(engine or method.engine, case.system)
    if (of_builder := getattr(builder, "model_error", None)) is None:
        return {}
    bounds: ModelError = of_builder(case.problem, case.scene.duration, method, step)
    return bounds
