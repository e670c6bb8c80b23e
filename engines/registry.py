"""The engines: modules of `adapters` with an ENGINE, and those that other installed packages add by
entry points of the group `plumbob.engines`; and their builders of systems."""

from __future__ import annotations

import importlib.util
import pkgutil
from collections.abc import Mapping, Sequence
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
from plumbob.models.registry import matches, unknown
from plumbob.models.scene import SMOOTH, Case, System

_ADAPTERS = "plumbob.engines.adapters"


@cache
def built_in() -> Mapping[str, Engine]:
    """The engines that plumbob has adapters for, in the order of their names, installed or not."""
    adapters = map(_adapter, _modules())
    return {e.name: e for e in sorted(filter(None, adapters), key=lambda engine: engine.name)}


@cache
def _modules() -> Sequence[str]:
    """The names of the modules of adapters."""
    folder = pkgutil.iter_modules([str(Path(__file__).parent / "adapters")])
    return [module.name for module in folder]


def _adapter(module: str) -> Engine | None:
    """The engine of a module of adapters; None without one."""
    engine: Engine | None = getattr(import_module(f"{_ADAPTERS}.{module}"), "ENGINE", None)
    return engine


@cache
def engines() -> Mapping[str, Engine]:
    """All engines by name, in the order of their names, installed or not; those of other packages
    among them, whose modules are loaded for it."""
    every = dict(built_in())
    for name, addition in _additions().items():
        if not addition.reason:
            every[name] = added.guarded(addition)
    return {name: every[name] for name in sorted(every)}


def _engines_of(*names: str) -> Mapping[str, Engine]:
    """The engines among which names of engines or methods are: those of other packages are loaded
    where a name is none of ours."""
    ours = built_in()
    return ours if all(name.partition("/")[0] in ours for name in names) else engines()


def find_engine(name: str) -> Engine:
    """The engine of this name; raises ParameterError."""
    if (engine := _engines_of(name).get(name)) is not None:
        return engine
    raise ParameterError("engine", name, _broken(name) or f"one of {', '.join(engines())}")


def limits_of(method: str) -> Limits:
    """The limits of the engine of a method, by the method's name; none of a stored study's engine
    that is no longer there."""
    name = method.partition("/")[0]
    # Most have a module of their name: the others are not loaded for it.
    engine = _adapter(name) if name in _modules() else None
    try:
        return declared_by(engine or find_engine(name))
    except ParameterError:
        return Limits()


def unguarded(name: str) -> Engine:
    """The engine of this name as its package gives it, whose errors are raised and whose output is
    seen; raises ParameterError."""
    engine = find_engine(name)
    return _additions()[name].found if engine.distribution else engine


def _additions() -> Mapping[str, entry_points.Addition]:
    return entry_points.additions(entry_points.ENGINES, _wrong)


def _broken(name: str) -> str:
    return entry_points.broken_requirement(entry_points.ENGINES, _wrong, name)


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


def methods(pattern: str = "*") -> tuple[Method, ...]:
    """Methods whose name, or engine, matches the shell pattern (several with commas), installed or
    not; raises ParameterError when one part of the pattern matches none."""
    wanted = pattern.split(",")
    every = [method for engine in _engines_of(*wanted).values() for method in engine.methods]
    for part in wanted:
        if not any(matches(method.name, part) for method in every):
            raise ParameterError("methods", part, _one_of(part))
    return tuple(m for m in every if any(matches(m.name, part) for part in wanted))


def method(name: str) -> Method:
    """The method `engine/name`; raises ParameterError when there is none."""
    for engine in _engines_of(name).values():
        for candidate in engine.methods:
            if candidate.name == name:
                return candidate
    raise ParameterError("method", name, _one_of(name))


def _one_of(name: str) -> str:
    """The requirement on a method's name: the names there are, or why one cannot be used."""
    every = [method.name for engine in engines().values() for method in engine.methods]
    return _broken(name.partition("/")[0]) or unknown(name, every)


def engine_of(method: Method) -> Engine:
    """The engine that a method belongs to; raises ParameterError where it is no longer there."""
    return find_engine(method.engine)


def find_builder(engine: str, system: System) -> ModuleType:
    """The module that builds `system` in an engine; raises Unsupported when there is none."""
    if (module := builder(engine, system)) is None:
        raise Unsupported(f"{engine} has no builder for {system.name}")
    return module


def builder(engine: str, system: System) -> ModuleType | None:
    """The module that builds `system` in an engine: the one that the system names for the engine,
    if it names one; else `adapters/<engine>/<family>.py`; else, for a smooth system,
    `adapters/<engine>/smooth_system.py`. None when there is none."""
    every = (system.family, "smooth_system") if system.kind == SMOOTH else (system.family,)
    names = [f"{_ADAPTERS}.{engine}.{module}" for module in every]
    for name in (system.builders[engine],) if engine in system.builders else names:
        try:
            return import_module(name)
        except ModuleNotFoundError as error:
            if error.name != name:
                raise
    return None


def model_error(case: Case, method: Method, step: float, engine: str = "") -> ModelError:
    """Bounds on what a builder's model adds to each observable, by reason, in the method's engine
    unless another is named: none where it has no `model_error`; raises Unsupported where the
    engine has neither a builder for the system nor a mechanism to build."""
    module = builder(engine or method.engine, case.system)
    if module is None and case.system.model_file is None:
        raise Unsupported(f"{engine or method.engine} has no builder for {case.system.name}")
    if (of_builder := getattr(module, "model_error", None)) is None:
        return {}
    bounds: ModelError = of_builder(case.problem, case.scene.duration, method, step)
    return bounds
