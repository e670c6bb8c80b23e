"""Which systems there are: every folder of `models` lists its own in SYSTEMS."""

from __future__ import annotations

import difflib
import fnmatch
import pickle
import pkgutil
from collections.abc import Mapping
from dataclasses import replace
from functools import cache, lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError, known
from plumbob.models.scene import Case, Scene, System


@cache
def systems() -> Mapping[str, System]:
    """All systems by name, in the order of their names.

    >>> "cone-pendulum" in systems()
    True
    """
    folders = pkgutil.iter_modules([str(Path(__file__).parent)])
    modules = [import_module(f"plumbob.models.{f.name}") for f in folders if f.ispkg]
    found = [system for module in modules for system in getattr(module, "SYSTEMS", ())]
    return {system.name: system for system in sorted(found, key=lambda system: system.name)}


def scenes(pattern: str = "*", profile: str = "full") -> tuple[Scene, ...]:
    """Scenes whose name, or system, matches the shell pattern (several with commas), of the
    profile; raises ParameterError when there is none."""
    every = [scene for system in systems().values() for scene in system.scenes]
    wanted = pattern.split(",")
    chosen = tuple(
        scene
        for scene in every
        if any(fnmatch.fnmatchcase(scene.name, w) or scene.system == w for w in wanted)
        and (profile == "full" or scene.profile == "quick" or scene.name in wanted)
    )
    for part in wanted:
        if not any(fnmatch.fnmatchcase(s.name, part) or s.system == part for s in every):
            raise ParameterError("scenes", part, unknown(part, [s.name for s in every]))
    return chosen


def scene(name: str, changes: Mapping[str, Any] | None = None) -> Scene:
    """The scene `system/case`, or a system's default case, with some parameters changed (SI units
    and radians; the names of `--set`).

    Raises ParameterError for an unknown name or a parameter that the equations do not allow.

    >>> scene("simple-pendulum/free-large").duration
    50.0
    >>> scene("cone-pendulum", {"gravity": 1.62}).name
    'cone-pendulum/rotating-base'
    >>> scene("cone-pendulum", {"gravity": -1.0})
    Traceback (most recent call last):
    plumbob.analytic.parameters.ParameterError: gravity = -1.0: must be 0 or greater
    """
    system = systems().get(name.partition("/")[0])
    if system is None:
        raise ParameterError("scene", name, unknown(name, list(systems())))
    cases = {scene.name: scene for scene in system.scenes}
    full = name if "/" in name else f"{name}/{system.default}"
    if full not in cases:
        raise ParameterError("scene", name, unknown(full, list(cases)))
    chosen = cases[full]
    if not changes:
        return chosen
    known(changes, system.parameters)
    changed = replace(chosen, parameters=system.change(chosen.parameters, changes))
    case_of(changed)  # raises where the equations do not allow it; kept for who runs it
    return changed


def system_of(scene: Scene) -> System:
    """The system that a scene belongs to."""
    return systems()[scene.system]


def case_of(scene: Scene) -> Case:
    """The case of a scene: its problem and its exact motion, which all scenes with the same
    parameters share; raises ParameterError."""
    found = _worked_out(scene.system, pickle.dumps(dict(scene.parameters)))
    return replace(found, scene=scene)


@lru_cache(maxsize=128)
def _worked_out(system: str, parameters: bytes) -> Case:
    """The case of a system with these pickled parameters, which no dict could be a key for."""
    of = systems()[system]
    return of.case(replace(of.scenes[0], parameters=pickle.loads(parameters)))


def unknown(name: str, names: list[str]) -> str:
    """What a name must be, with the nearest ones that exist."""
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.4) or names[:8]
    more = "" if len(near) == len(names) else ", ... (see `plumbob list`)"
    return f"one of {', '.join(near)}{more}"
