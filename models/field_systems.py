"""Builders of systems whose parameters are the fields of a dataclass, with an MJCF file named as
the system's family."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.parameters import known
from plumbob.analytic.reference import Array, Signals
from plumbob.models.scene import ON_PLANE, SMOOTH, Parameters, System, from_analytic


def field_names(model: type[Any]) -> tuple[str, ...]:
    """Returns the names of a dataclass's fields: the parameters of its system."""
    return tuple(field.name for field in fields(model))


def field_values(model: type[Any], values: Sequence[Any]) -> Parameters:
    """Returns the parameters of a scene from the values of all fields, in their order."""
    return MappingProxyType(dict(zip(field_names(model), values, strict=True)))


def field_system(model: type[Any], mjcf: Path | None = None, **about: Any) -> System:
    """Returns the system of a dataclass with the model file `mjcf`. Without `mjcf` it is plumbob's
    file that is named as the dataclass's module. `about` are the other fields of
    `plumbob.models.scene.System`, by name."""
    names = field_names(model)
    module_name = model.__module__.rpartition(".")[2]
    mjcf = mjcf or Path(__file__).parent / module_name / f"{module_name}.xml"
    return System(
        parameters=names,
        problem=partial(_checked_problem, model, names),
        mjcf=mjcf,
        family=mjcf.stem,
        **about,
    )


def smooth_system(model: type[Any], mjcf: Path | None = None, **about: Any) -> System:
    """Returns the system of a dataclass that has a certified exact `motion`. If the mechanism has a
    loop that engines close softly, the dataclass's `soft` describes that. The energy is conserved,
    unless `about` has other invariants. The arguments are those of `field_system`."""
    smooth_errors = from_analytic("errors.smooth_motion.stepped_system.smooth_errors")
    smooth_stability = from_analytic("errors.stability.smooth_systems.smooth_stability")
    about = {
        "invariants": energy_drift,
        "errors": lambda problem: smooth_errors(problem.motion, getattr(problem, "soft", None)),
        "stability": lambda problem: smooth_stability(problem.motion),
        **about,
    }
    return field_system(
        model,
        mjcf,
        reference=lambda problem: problem.motion,
        kind=SMOOTH,
        **about,
    )


def contact_system(
    model: type[Any], mjcf: Path | None = None, theory: str = "", **about: Any
) -> System:
    """Returns the system of a dataclass of bodies in contact that is its own reference and
    conserves nothing. `theory`, MODULE.FUNCTION below `plumbob.analytic`, is the theory of the
    steps' errors. The other arguments are those of `field_system`."""
    return field_system(
        model,
        mjcf,
        reference=lambda problem: problem,
        errors=from_analytic(theory),
        invariants=lambda problem, observed: {},
        kind=ON_PLANE,
        **about,
    )


def energy(problem: Any, observed: Signals) -> Array:
    """Returns the energy [J], shape (n,), of a problem whose `potential` energy [J] is a function
    of the observables."""
    kinetic = problem.motion.system.kinetic_energy(observed)
    return np.asarray(kinetic + problem.potential(observed))


def energy_at_start(problem: Any) -> float:
    """Returns the energy at time 0 [J]."""
    system = problem.motion.system
    return float(energy(problem, system.observed(system.start[:, None]))[0])


def energy_drift(problem: Any, observed: Signals) -> Signals:
    """Returns the relative drift of the energy. The scale is the energy at the start or the
    problem's `lift` [J], the largest energy that its weight can take and give, whichever is larger.
    If both are 0, the scale is the largest potential energy of the run."""
    energies = energy(problem, observed)
    scale = max(abs(energies[0]), getattr(problem, "lift", 0.0))
    scale = scale or float(np.abs(problem.potential(observed)).max())
    return {"energy": (energies - energies[0]) / scale} if scale else {}


def _checked_problem(model: type[Any], names: tuple[str, ...], parameters: Parameters) -> Any:
    """Returns the problem that parameters describe; raises ParameterError."""
    known(parameters, names)
    return model(**parameters)
