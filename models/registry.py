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
def built_in_systems() -> Mapping[str, System]:
    """Returns plumbob's own systems by name, sorted by name."""
    folders = pkgutil.iter_modules([str(Path(__file__).parent)])
    declared: list[System] = []
    for folder in folders:
        if folder.ispkg:
            module = import_module(f"plumbob.models.{folder.name}")
            declared += getattr(module, "SYSTEMS", ())
    by_name = sorted(declared, key=lambda system: system.name)
    return {system.name: _with_kind(system) for system in by_name}


def _with_kind(system: System) -> System:
    """Returns a system whose scenes state the system's kind."""
    scenes = tuple(replace(scene, kind=system.kind) for scene in system.scenes)
    return replace(system, scenes=scenes)


@cache
def systems() -> Mapping[str, System]:
    """Returns all systems by name, sorted by name.

    >>> "cone-pendulum" in systems()
    True
    """
    every = dict(built_in_systems())
    for name, addition in entry_points.additions(entry_points.SYSTEMS, _system_fault).items():
        if not addition.reason:
            kind = addition.found.kind or ONE_SMOOTH
            system = replace(addition.found, distribution=addition.distribution, kind=kind)
            every[name] = _with_kind(system)
    return {name: every[name] for name in sorted(every)}


def systems_of(*names: str) -> Mapping[str, System]:
    """Returns a mapping of systems that has every system with one of these names, or with a scene
    of one of these names. Other packages are loaded only if plumbob itself lacks one of the
    systems."""
    own_systems = built_in_systems()
    all_known = all(name.partition("/")[0] in own_systems for name in names)
    return own_systems if all_known else systems()


def find_system(name: str) -> System:
    """Returns the system of this name; raises ParameterError."""
    system = systems_of(name).get(name)
    if system is None:
        raise ParameterError("scene", name, _name_requirement(name, systems()))
    return system


def added_system(name: str) -> System | None:
    """Returns the system that another package adds under this name; None if no package does."""
    # The names of packages' entry points are tested first: `built_in` loads plumbob's systems.
    added_names = entry_points.entry_points_by_name(entry_points.SYSTEMS)
    if name not in added_names or name in built_in_systems():
        return None
    return systems().get(name)


def _name_requirement(name: str, names: Iterable[str]) -> str:
    """Returns the requirement on a name of a system or a scene, for a message: the reason why its
    package cannot be used, or the nearest names."""
    system = name.partition("/")[0]
    broken = entry_points.broken_requirement(entry_points.SYSTEMS, _system_fault, system)
    return broken or unknown(name, list(names))


def _system_fault(candidate: Any, name: str) -> str:
    """Message if a package's object is not a valid system of this name; empty if it is."""
    if not isinstance(candidate, System):
        return f"{type(candidate).__name__} in place of a plumbob System"
    if name in built_in_systems():
        return f"plumbob has a system called {name!r} itself"
    if candidate.name != name:
        return f"the system is called {candidate.name!r}, its entry point {name!r}"
    cases = [scene.name for scene in candidate.scenes if isinstance(scene, Scene)]
    if len(cases) != len(candidate.scenes) or f"{name}/{candidate.default}" not in cases:
        return f"no scene is called {name}/{candidate.default}"
    foreign = [case for case in cases if case.partition("/")[0] != name]
    if foreign:
        return f"the scene {foreign[0]!r} is none of {name!r}"
    for scene in candidate.scenes:
        try:
            with border():
                fault = _scene_fault(candidate, scene)
        except Refused as error:
            return f"{scene.name}: {error}"
        if fault:
            return fault
    return ""


def _scene_fault(system: System, scene: Scene) -> str:
    """Message if the exact motion of a scene, or its uncertainty, is not finite at the start or the
    end; empty if it is. Raises the exceptions of an added system's functions."""
    case = system.case(scene)
    ends = np.array([0.0, scene.duration])
    for values in (case.reference.observe(ends), case.reference.uncertainty(ends)):
        for observable in system.observables:
            if not np.isfinite(values[observable.name]).all():
                return f"{scene.name}: {observable.name} is not finite"
    system.quantities(case)  # called for the exceptions that it may raise
    return ""


def matches(name: str, pattern: str) -> bool:
    """Whether `system/case` or `engine/method` matches a shell pattern, or belongs to the system or
    engine that `pattern` names."""
    return fnmatch.fnmatchcase(name, pattern) or name.partition("/")[0] == pattern


def matching_scenes(pattern: str = "*", profile: str = "full") -> tuple[Scene, ...]:
    """Returns the scenes of a profile whose name, or system, matches the shell pattern (several
    with commas); raises ParameterError if there is none."""
    patterns = pattern.split(",")
    every = _scenes_of(systems_of(*patterns))
    for part in patterns:
        if not any(matches(scene.name, part) for scene in every):
            names = (scene.name for scene in _scenes_of(systems()))
            raise ParameterError("scenes", part, _name_requirement(part, names))

    def is_chosen(scene: Scene) -> bool:
        """Whether a scene belongs to the profile, or is named in full, and matches a pattern."""
        in_profile = profile == "full" or scene.profile == "quick" or scene.name in patterns
        return in_profile and any(matches(scene.name, part) for part in patterns)

    return tuple(scene for scene in every if is_chosen(scene))


def _scenes_of(some: Mapping[str, System]) -> list[Scene]:
    """Returns the scenes of some systems, system by system."""
    every: list[Scene] = []
    for system in some.values():
        every += system.scenes
    return every


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
    full_name = name if "/" in name else f"{name}/{system.default}"
    if full_name not in cases:
        raise ParameterError("scene", name, unknown(full_name, list(cases)))
    chosen = cases[full_name]
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
    case = _cached_case(scene.system, pickle.dumps(dict(scene.parameters)))
    return replace(case, scene=scene)


def stability_of(case: Case) -> StabilityTheory | None:
    """Returns the theory of the largest step of a case, computed once for all methods; None without
    a theory."""
    return _cached_stability(case.system.name, pickle.dumps(dict(case.scene.parameters)))


@lru_cache(maxsize=16)
def _cached_stability(system: str, parameters: bytes) -> StabilityTheory | None:
    """Returns the theory of the largest step of a system with these pickled parameters."""
    case = _cached_case(system, parameters)
    return case.system.stability(case.problem) if case.system.stability else None


@lru_cache(maxsize=128)
def _cached_case(system: str, parameters: bytes) -> Case:
    """Returns the case of a system with these parameters. They are pickled because a dict cannot be
    a key of the cache."""
    owner = find_system(system)
    scene = replace(owner.scenes[0], parameters=pickle.loads(parameters))
    return owner.case(scene)


def unknown(name: str, names: list[str]) -> str:
    """Returns the requirement on an unknown name, for a message: the nearest names that exist."""
    return f"one of {nearest(name, names, '... (see `plumbob list`)')}"
