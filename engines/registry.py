"""Which engines there are (modules of `adapters` with an ENGINE), and their builders of systems."""

from __future__ import annotations

import fnmatch
import importlib.util
import pkgutil
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.machinery import PathFinder
from pathlib import Path
from types import ModuleType

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import Engine, Method, Unsupported
from plumbob.models.registry import unknown
from plumbob.models.scene import System

_ADAPTERS = "plumbob.engines.adapters"


@cache
def engines() -> Mapping[str, Engine]:
    """All engines by name, in the order of their names, installed or not."""
    found = [
        getattr(import_module(f"{_ADAPTERS}.{module.name}"), "ENGINE", None)
        for module in pkgutil.iter_modules([str(Path(__file__).parent / "adapters")])
    ]
    return {e.name: e for e in sorted(filter(None, found), key=lambda engine: engine.name)}


def installed(engine: Engine) -> bool:
    """Whether the engine's package is there; a package inside another is looked for without
    importing that one."""
    outer, _, inner = engine.package.rpartition(".")
    found = importlib.util.find_spec(outer or inner)
    if found is None or not outer:
        return found is not None
    return PathFinder.find_spec(inner, found.submodule_search_locations) is not None


def methods(pattern: str = "*") -> tuple[Method, ...]:
    """Methods whose name, or engine, matches the shell pattern (several with commas), installed or
    not; raises ParameterError when one part of the pattern matches none."""
    every = [method for engine in engines().values() for method in engine.methods]
    wanted = pattern.split(",")
    for part in wanted:
        if not any(_matches(method, part) for method in every):
            raise ParameterError("methods", part, unknown(part, [m.name for m in every]))
    return tuple(m for m in every if any(_matches(m, part) for part in wanted))


def method(name: str) -> Method:
    """The method `engine/name`; raises ParameterError when there is none."""
    every = {method.name: method for engine in engines().values() for method in engine.methods}
    if name not in every:
        raise ParameterError("method", name, unknown(name, list(every)))
    return every[name]


def engine_of(method: Method) -> Engine:
    """The engine that a method belongs to."""
    return engines()[method.engine]


def _matches(method: Method, pattern: str) -> bool:
    return fnmatch.fnmatchcase(method.name, pattern) or method.engine == pattern


def find_builder(engine: str, system: System) -> ModuleType:
    """The module `adapters/<engine>/<family>.py` that builds `system`; raises Unsupported when
    the engine has none."""
    name = f"{_ADAPTERS}.{engine}.{system.family}"
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        raise Unsupported(f"{engine} has no builder for {system.name}") from None
