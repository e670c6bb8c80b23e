"""The registry of systems. Each folder of `models` lists its systems in SYSTEMS. Other installed
packages add systems by entry points of the group `plumbob.systems`."""

from __future__ import annotations

import fnmatch
import pickle
import pkgutil
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache, lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError, known, nearest
from plumbob.analytic.stability import StabilityTheory
from plumbob.models import entry_points
from plumbob.models.border import Refused, border
from plumbob.models.scene import ONE_SMOOTH, Case, Scene, System


@cache
def built_in() -> Mapping[str, System]:
    """Returns plumbob's own systems by name, sorted by name."""
    folders = pkgutil.iter_modules([str(Path(__file__).parent)])
    modules = [import_module(f"plumbob.models.{f.name}") for f in folders if f.ispkg]
    declared = [system for module in modules for system in getattr(module, "SYSTEMS", ())]
    return {s.name: _of_its_kind(s) for s in sorted(declared, key=lambda system: system.name)}


def _of_its_kind(system: System) -> System:
    """Returns a system whose scenes state the system's kind."""
    return replace(system, scenes=tuple(replace(s, kind=system.kind) for s in system.scenes))


@cache
def systems() -> Mapping[str, System]:
    """Returns all systems by name, sorted by name.

    >>> "cone-pendulum" in systems()
    True
    """
    every = dict(built_in())
    for name, added in entry_points.additions(entry_points.SYSTEMS, _wrong).items():
        if not added.reason:
            kind = added.found.kind or ONE_SMOOTH
            system = replace(added.found, distribution=added.distribution, kind=kind)
            every[name] = _of_its_kind(system)
    return {name: every[name] for name in sorted(every)}


def systems_of(*names: str) -> Mapping[str, System]:
    """Returns systems among which the systems with these names, or with scenes of these names, are.
    Other packages are loaded only if plumbob itself has no system of one of the names."""
    ours = built_in()
    return ours if all(name.partition("/")[0] in ours for name in names) else systems()


def find_system(name: str) -> System:
    """Returns the system of this name; raises ParameterError."""
    if (system := systems_of(name).get(name)) is not None:
        return system
    raise ParameterError("scene", name, _one_of(name, systems()))


def added_system(name: str) -> System | None:
    """Returns the system that another package adds under this name; None if no package does."""
    # If no package adds the name, nothing needs to be loaded.
    added = name in entry_points.points(entry_points.SYSTEMS) and name not in built_in()
    return systems().get(name) if added else None


def _one_of(name: str, names: Iterable[str]) -> str:
    """Returns the requirement on a name of a system or a scene, for a message: the reason why its
    package cannot be used, or the nearest names."""
    system = name.partition("/")[0]
    return entry_points.broken(entry_points.SYSTEMS, _wrong, system) or unknown(
        name, list(names)
    )


def _wrong(candidate: Any, name: str) -> str:
    """Message if a package's object is not a valid system of this name; empty if it is. The exact
    motion of each scene is evaluated once, at its start and its end."""
    if not isinstance(candidate, System):
        return f"{type(candidate).__name__} in place of a plumbob System"
    if name in built_in():
        return f"plumbob has a system called {name!r} itself"
    if candidate.name != name:
        return f"the system is called {candidate.name!r}, its entry point {name!r}"
    cases = [scene.name for scene in candidate.scenes if isinstance(scene, Scene)]
    if len(cases) != len(candidate.scenes) or f"{name}/{candidate.default}" not in cases:
        return f"no scene is called {name}/{candidate.default}"
    if foreign := [case for case in cases if case.partition("/")[0] != name]:
        return f"the scene {foreign[0]!r} is none of {name!r}"
    for scene in candidate.scenes:
        try:
            with border():
                case = candidate.case(scene)
                ends = np.array([0.0, scene.duration])
                for values in (case.reference.observe(ends), case.reference.uncertainty(ends)):
                    for observable in candidate.observables:
                        if not np.isfinite(values[observable.name]).all():
                            return f"{scene.name}: {observable.name} is not finite"
                candidate.quantities(case)
        except Refused as error:
            return f"{scene.name}: {error}"
    return ""


def matches(name: str, pattern: str) -> bool:
    """Whether `system/case` or `engine/method` matches a shell pattern, or belongs to the system or
    engine that `pattern` names."""
    return fnmatch.fnmatchcase(name, pattern) or name.partition("/")[0] == pattern


def scenes(pattern: str = "*", profile: str = "full") -> tuple[Scene, ...]:
    """Returns the scenes of a profile whose name, or system, matches the shell pattern (several
    with commas); raises ParameterError if there is none."""
    wanted = pattern.split(",")
    every = [scene for system in systems_of(*wanted).values() for scene in system.scenes]
    for part in wanted:
        if not any(matches(scene.name, part) for scene in every):
            names = (scene.name for system in systems().values() for scene in system.scenes)
            raise ParameterError("scenes", part, _one_of(part, names))
    return tuple(
        scene
        for scene in every
        if any(matches(scene.name, part) for part in wanted)
        and (profile == "full" or scene.profile == "quick" or scene.name in wanted)
    )


def scene(name: str, changes: Mapping[str, Any] | None = None) -> Scene:
    """Returns the scene `system/case`, or a system's default case, with some parameters changed (SI
    units and radians, by the names of `--set`).

    Raises ParameterError for an unknown name, and for a parameter that the equations do not allow.

    >>> scene("simple-pendulum/free-large").duration
    50.0
    >>> scene("cone-pendulum", {"gravity": 1.62}).name
    'cone-pendulum/rotating-base'
    >>> scene("cone-pendulum", {"gravity": -1.0})
    Traceback (most recent call last):
    plumbob.analytic.parameters.ParameterError: gravity = -1.0: must be 0 or greater
    """
    system = find_system(name.partition("/")[0])
    cases = {scene.name: scene for scene in system.scenes}
    full = name if "/" in name else f"{name}/{system.default}"
    if full not in cases:
        raise ParameterError("scene", name, unknown(full, list(cases)))
    chosen = cases[full]
    if not changes:
        return chosen
    known(changes, system.parameters)
    changed = replace(chosen, parameters=system.change(chosen.parameters, changes))
    try:
        case_of(changed)  # the run finds the case in the cache
    except ParameterError as error:
        raise error.due_to(changes, system.parameters) from None
    return changed


def system_of(scene: Scene) -> System:
    """Returns the system of a scene; raises ParameterError if the system is no longer installed."""
    return find_system(scene.system)


def case_of(scene: Scene) -> Case:
    """Returns the case of a scene: its problem and its exact motion. All scenes with the same
    parameters share one case. Raises ParameterError."""
    case = _worked_out(scene.system, pickle.dumps(dict(scene.parameters)))
    return replace(case, scene=scene)


def stability_of(case: Case) -> StabilityTheory | None:
    """Returns the theory of the largest step of a case, computed once for all methods; None without
    a theory."""
    return _stability(case.system.name, pickle.dumps(dict(case.scene.parameters)))


@lru_cache(maxsize=16)
def _stability(system: str, parameters: bytes) -> StabilityTheory | None:
    """Returns the theory of the largest step of a system with these pickled parameters."""
    case = _worked_out(system, parameters)
    return case.system.stability(case.problem) if case.system.stability else None


@lru_cache(maxsize=128)
def _worked_out(system: str, parameters: bytes) -> Case:
    """Returns the case of a system with these parameters. They are pickled because a dict cannot be
    a key of the cache."""
    of = find_system(system)
    return of.case(replace(of.scenes[0], parameters=pickle.loads(parameters)))


def unknown(name: str, names: list[str]) -> str:
    """Returns the requirement on an unknown name, for a message: the nearest names that exist."""
    return f"one of {nearest(name, names, '... (see `plumbob list`)')}"
