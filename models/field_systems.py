"""Systems whose parameters are the fields of a dataclass, with an MJCF file named as the family."""

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
    """The names of its parameters."""
    return tuple(field.name for field in fields(model))


def field_values(model: type[Any], values: Sequence[Any]) -> Parameters:
    """Parameters of a scene, by the values of all fields in their order."""
    return MappingProxyType(dict(zip(field_names(model), values, strict=True)))


def field_system(model: type[Any], mjcf: Path | None = None, **about: Any) -> System:
    """The system of a dataclass with the model in the file `mjcf`, without one that of plumbob
    which is named as its module; the other fields of `plumbob.models.scene.System` are given by
    name."""
    names = field_names(model)
    own = model.__module__.rpartition(".")[2]
    mjcf = mjcf or Path(__file__).parent / own / f"{own}.xml"
    return System(
        parameters=names,
        problem=partial(_problem, model, names),
        mjcf=mjcf,
        family=mjcf.stem,
        **about,
    )


def smooth_system(model: type[Any], mjcf: Path | None = None, **about: Any) -> System:
    """The same for a dataclass whose exact `motion` is certified, and whose loop, where it has one,
    engines close with a `soft` constraint; its energy is conserved, unless `about` has other
    invariants."""
    about = {
        "invariants": energy_drift,
        "errors": lambda problem: from_analytic(
            "errors.smooth_motion.stepped_system.smooth_errors"
        )(problem.motion, getattr(problem, "soft", None)),
        "stability": lambda problem: from_analytic(
            "errors.stability.smooth_systems.smooth_stability"
        )(problem.motion),
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
    """The same for a dataclass that is its own reference, of bodies in contact, which conserve
    nothing; `theory`, MODULE.FUNCTION below `plumbob.analytic`, is that of its steps' errors."""
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
    """Energy [J] of a problem with a `potential` energy [J] of its observables, shape (n,)."""
    kinetic = problem.motion.system.kinetic_energy(observed)
    return np.asarray(kinetic + problem.potential(observed))


def energy_at_start(problem: Any) -> float:
    """The energy at time 0 [J]."""
    system = problem.motion.system
    return float(energy(problem, system.observed(system.start[:, None]))[0])


def energy_drift(problem: Any, observed: Signals) -> Signals:
    """Drift of the energy, relative to that at the start, or to a problem's `lift` [J], which its
    weight can take and give, where that is more; to what it gives where both are 0."""
    energies = energy(problem, observed)
    scale = max(abs(energies[0]), getattr(problem, "lift", 0.0))
    scale = scale or float(np.abs(problem.potential(observed)).max())
    return {"energy": (energies - energies[0]) / scale} if scale else {}


def _problem(model: type[Any], names: tuple[str, ...], parameters: Parameters) -> Any:
    """The problem that parameters describe; raises ParameterError."""
    known(parameters, names)
    return model(**parameters)
