"""All engines, and their builders of systems. Engines are the modules of `adapters` with an ENGINE,
and the entry points of the group `plumbob.engines` of other installed packages."""

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
    """The engines that plumbob has adapters for, sorted by name, installed or not."""
    adapters = map(_adapter, _modules())
    by_name = sorted(filter(None, adapters), key=lambda engine: engine.name)
    return {engine.name: engine for engine in by_name}


@cache
def _modules() -> Sequence[str]:
    """The names of the modules of adapters."""
    folder = pkgutil.iter_modules([str(Path(__file__).parent / "adapters")])
    return [module.name for module in folder]


def _adapter(module: str) -> Engine | None:
    """The engine of a module of `adapters`; None if the module has no ENGINE."""
    engine: Engine | None = getattr(import_module(f"{_ADAPTERS}.{module}"), "ENGINE", None)
    return engine


@cache
def engines() -> Mapping[str, Engine]:
    """All engines, sorted by name, installed or not. The modules of engines of other packages are
    imported."""
    every = dict(built_in())
    for name, addition in _additions().items():
        if not addition.reason:
            every[name] = added.guarded(addition)
    return {name: every[name] for name in sorted(every)}


def _engines_of(*names: str) -> Mapping[str, Engine]:
    """The engines among which to look for names of engines or methods. If all names are plumbob's,
    modules of other packages are not imported."""
    ours = built_in()
    return ours if all(name.partition("/")[0] in ours for name in names) else engines()


def find_engine(name: str) -> Engine:
    """The engine of this name; raises ParameterError."""
    if (engine := _engines_of(name).get(name)) is not None:
        return engine
    raise ParameterError("engine", name, _broken(name) or f"one of {', '.join(engines())}")


def limits_of(method: str) -> Limits:
    """The limits of the engine of a method, by the method's name; no limits if the engine, which a
    stored study may name, is no longer installed."""
    name = method.partition("/")[0]
    # Most engines have a module of their name: then no other module is imported.
    engine = _adapter(name) if name in _modules() else None
    try:
        return declared_by(engine or find_engine(name))
    except ParameterError:
        return Limits()


def unguarded(name: str) -> Engine:
    """The engine of this name, without the guard around engines of other packages: exceptions are
    raised, and output is printed. Raises ParameterError if there is none."""
    engine = find_engine(name)
    return _additions()[name].found if engine.distribution else engine


def _additions() -> Mapping[str, entry_points.Addition]:
    """The engines of other packages by name, with reasons for those that cannot be used."""
    return entry_points.additions(entry_points.ENGINE_GROUP, _wrong)


def _broken(name: str) -> str:
    """The reason why the engine of another package cannot be used; empty if there is none."""
    return entry_points.broken_requirement(entry_points.ENGINE_GROUP, _wrong, name)


def _wrong(engine: object, name: str) -> str:
    """The reason why an object is no engine of this name; empty if it is one."""
    if name in built_in():
        return f"plumbob has an engine called {name!r} itself"
    return added.wrong(engine, name)


def installed(engine: Engine) -> bool:
    """Whether the engine's package is installed. No package is imported to find out."""
    outer, _, inner = engine.package.rpartition(".")
    spec = importlib.util.find_spec(outer or inner)
    if spec is None or not outer:
        return spec is not None
    return PathFinder.find_spec(inner, spec.submodule_search_locations) is not None


def methods(pattern: str = "*") -> tuple[Method, ...]:
    """The methods whose name or engine matches a shell pattern, or one of several patterns
    separated by commas, installed or not. Raises ParameterError if one of the patterns matches
    none."""
    wanted = pattern.split(",")
    every = [method for engine in _engines_of(*wanted).values() for method in engine.methods]
    for part in wanted:
        if not any(matches(method.name, part) for method in every):
            raise ParameterError("methods", part, _one_of(part))
    return tuple(
        method for method in every if any(matches(method.name, part) for part in wanted)
    )


def method(name: str) -> Method:
    """The method of this name, `engine/name`; raises ParameterError if there is none."""
    for engine in _engines_of(name).values():
        for candidate in engine.methods:
            if candidate.name == name:
                return candidate
    raise ParameterError("method", name, _one_of(name))


def _one_of(name: str) -> str:
    """Returns a text that says what a method's name must be: one of the known names. If the engine
    of `name` cannot be used, the text says why."""
    every = [method.name for engine in engines().values() for method in engine.methods]
    return _broken(name.partition("/")[0]) or unknown(name, every)


def engine_of(method: Method) -> Engine:
    """The engine of a method; raises ParameterError if it is no longer installed."""
    return find_engine(method.engine)


def find_builder(engine: str, system: System) -> ModuleType:
    """The module that builds `system` in an engine; raises Unsupported if there is none."""
    if (module := builder(engine, system)) is None:
        raise Unsupported(f"{engine} has no builder for {system.name}")
    return module


def builder(engine: str, system: System) -> ModuleType | None:
    """The module that builds `system` in an engine, or None: the module that the system names for
    the engine, if it names one; else `adapters/<engine>/<family>.py`; else, for a smooth system,
    `adapters/<engine>/smooth_system.py`."""
    modules = (system.family, "smooth_system") if system.kind == SMOOTH else (system.family,)
    names = [f"{_ADAPTERS}.{engine}.{module}" for module in modules]
    if engine in system.builders:
        names = [system.builders[engine]]
    for name in names:
        try:
            return import_module(name)
        except ModuleNotFoundError as error:
            if error.name != name:
                raise
    return None


def model_error(case: Case, method: Method, step: float, engine: str = "") -> ModelError:
    """Bounds on the errors that a builder's model makes in each observable, by reason. The builder
    is the one of the method's engine, unless another `engine` is named; without a `model_error` it
    has no bounds. Raises Unsupported if the engine has neither a builder for the system nor a
    mechanism to build."""
    module = builder(engine or method.engine, case.system)
    if module is None and case.system.model_file is None:
        raise Unsupported(f"{engine or method.engine} has no builder for {case.system.name}")
    if (of_builder := getattr(module, "model_error", None)) is None:
        return {}
    bounds: ModelError = of_builder(case.problem, case.scene.duration, method, step)
    return bounds
