"""plumbob gradient: derivatives of a method's results, or of a model file's motion, and their
errors."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

from plumbob.analytic.parameters import ParameterError, nearest
from plumbob.engines.method import Method, Unsupported, meant
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.codec import hashable
from plumbob.engines.study.gradient import GradientSearch
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.shared.budget import certify
from plumbob.reports.commands.shared.model_file import (
    is_model_file,
    model_and_script,
    motion_record,
)
from plumbob.reports.commands.shared.searches import search_study
from plumbob.reports.judge.gradients import study_gradients
from plumbob.reports.judge.searches import unexpected_searches
from plumbob.reports.view.tables import table
from plumbob.reports.view.terminal import aligned

if TYPE_CHECKING:
    from plumbob.engines.audit.gradient import CertifiedGradient
    from plumbob.engines.audit.reference import Certificate
    from plumbob.engines.own_motion import OwnModel, Script

INCOMPLETE = 3
# Options that a model file does not take.
SCENE_OPTIONS = ("way", "step", "eps", "at", "jobs", "changes")


def command(chosen: argparse.Namespace) -> int:
    """Measures, judges and prints derivatives. Returns 1 if a verdict is not as expected, 3 if an
    engine is missing."""
    if is_model_file(chosen, SCENE_OPTIONS):
        return _print_file_gradient(chosen)
    if not chosen.method:
        raise ParameterError("method", None, "given: engine/name")
    changed = chosen.changes
    methods = [find_method(name) for name in dict.fromkeys(chosen.method)]
    with values.representable(changed, chosen):
        case = case_of(find_scene(chosen.scene, changed))
        certify(case, chosen.at or case.scene.duration, chosen.budget)
        searches: list[GradientSearch] = []
        for method in methods:
            searches += _gradient_searches(chosen, case, method, changed)
        judged = list(study_gradients(search_study(chosen, methods, searches)))
    records = [gradient.record() for gradient in judged]
    shown = aligned(table("gradients", records=records))
    values.show(chosen, records, "gradient", rows=shown, judged=judged)
    if unexpected_searches(judged):
        return 1
    engines = [engine_of(method) for method in methods]
    missing_packages = [engine.package for engine in engines if not installed(engine)]
    for package in dict.fromkeys(missing_packages):
        print(f"{package} is not installed", file=sys.stderr)
    return INCOMPLETE if missing_packages else 0


def _print_file_gradient(chosen: argparse.Namespace) -> int:
    """Prints derivatives of the joint coordinates at the end of a model file's motion by its start
    and its controls. Returns 3 if the engine is missing or cannot express the file, or if no chosen
    derivative is both certified and computed by the method."""
    from plumbob.engines.audit.gradient import numbers_of
    from plumbob.engines.audit.user_models import quiet
    from plumbob.engines.study.provenance import version_of
    from plumbob.reports.commands.arguments.console import note, progress
    from plumbob.reports.view.audit.page import package_versions
    from plumbob.reports.view.audit.records import gradient_record

    with quiet(), progress() as show:
        model, script = model_and_script(chosen)
        method, model = _file_method(chosen, model)
        outputs = _matching_names("of", chosen.of, model.names["position"])
        inputs = _matching_names("by", chosen.by, numbers_of(model))
        try:
            reference, gradient = _certified_file_gradient(
                chosen, method, model, script, lambda part: show(part, 0, 0)
            )
        except Unsupported as reason:
            note(str(reason))
            return INCOMPLETE
    selection = {"gradient": gradient.between(outputs, inputs)}
    engine = engine_of(method)
    answer = {
        **motion_record(chosen, script, reference, reference.known),
        "method": method.name,
        "step": model.step,
        **gradient_record(gradient),
        **(selection if chosen.of or chosen.by else {}),
        "versions": {**package_versions(), engine.name: version_of(engine)},
    }
    shown = aligned(table("file_gradients", entries=answer["gradient"]))
    values.show(chosen, answer, "gradient_file", rows=shown, known=gradient, **answer)
    comparable = (
        math.isfinite(entry["exact"]) and entry["computed"] is not None
        for entry in answer["gradient"]
    )
    return 0 if any(comparable) else INCOMPLETE


def _certified_file_gradient(
    chosen: argparse.Namespace,
    method: Method,
    model: OwnModel,
    script: Script,
    show: Callable[[str], None],
) -> tuple[Certificate, CertifiedGradient]:
    """Returns the certified motion of a model file, and the derivatives of its end: certified, and
    as the method computes them. Raises Unsupported with a whole sentence as its reason if there are
    none."""
    from plumbob.engines.audit.allowance import Allowance
    from plumbob.engines.audit.audit import REFERENCE
    from plumbob.engines.audit.gradient import certified_gradient
    from plumbob.engines.audit.reference import certified
    from plumbob.engines.own_motion import NotCertifiable

    engine = engine_of(method)
    if not installed(engine):
        raise Unsupported(f"{engine.package} is not installed")
    allowance = Allowance(chosen.budget, progress=show)
    reference = certified(model, script, allowance.part(REFERENCE))
    try:
        more_time = Allowance(chosen.budget, progress=show)
        gradient = certified_gradient(
            model, script, reference, reference.known, more_time, method
        )
    except NotCertifiable as why:
        sentence = f"{chosen.scene} has no derivatives that are certified: {why}"
        raise Unsupported(sentence) from None
    except Unsupported as why:
        raise Unsupported(f"{method.name} does not run {chosen.scene}: {why}") from None
    return reference, gradient


def _file_method(chosen: argparse.Namespace, model: OwnModel) -> tuple[Method, OwnModel]:
    """Returns the method for a model file, and the model with that method's integrator if the
    method is one of MuJoCo's. Without a name on the command line, the method is the model's own
    integrator. Raises ParameterError."""
    from plumbob.engines.audit.step_of_method import DISCRETE, runs_of

    names = chosen.method or [f"mujoco/{model.integrator}"]
    if len(names) > 1:
        raise ParameterError("method", names, "one method, with a model file")
    method = find_method(names[0])
    run = runs_of(method, (*model.steppable, DISCRETE))
    if run != method.name:
        model = model.with_integrators((run,))
    return method, model


def _matching_names(option: str, text: str | None, names: Sequence[str]) -> list[str]:
    """Returns the names that the text of an option means; all names if the text is empty. A word
    means a name, all names of a kind, or all kinds of a name. Raises ParameterError."""
    if not text:
        return list(names)
    selected = list[str]()
    for word in text.split(","):
        matching = []
        for name in names:
            kind, _, name_alone = name.partition(" ")
            if word in (name, kind, name_alone):
                matching.append(name)
        if not matching:
            raise ParameterError(option, word, f"one of {nearest(word, names)}")
        selected += matching
    return list(dict.fromkeys(selected))


def _gradient_searches(
    chosen: argparse.Namespace, case: Case, method: Method, changed: dict[str, object]
) -> list[GradientSearch]:
    """Returns a search for each parameter and step. Raises ParameterError."""
    from plumbob.models.gradient import numbers

    scene = case.scene
    if not meant(method, scene):
        raise ParameterError("method", method.name, f"one that is meant for {scene.name}")
    if chosen.of:
        observables = chosen.of.split(",")
    else:
        observables = [quantity.observable for quantity in case.system.quantities(case)]
    parameters = chosen.by.split(",") if chosen.by else _default_parameters(case)
    for name in parameters:
        next(numbers(case, name))  # raises ParameterError if the scene has no such number
    search = GradientSearch(
        scene=scene.name,
        method=method.name,
        of=tuple(dict.fromkeys(observables)),
        by="",
        ways=tuple(dict.fromkeys(chosen.way or ())),
        eps=tuple(chosen.eps or ()),
        at=chosen.at,
        changes=tuple(hashable(changed).items()),
    )
    search.check(case)
    steps = dict.fromkeys(chosen.step or (None,))
    combinations = product(dict.fromkeys(parameters), steps)
    return [replace(search, by=name, step=step) for name, step in combinations]


def _default_parameters(case: Case) -> list[str]:
    """Returns the names of the scene's start and of its numbers that are not 0."""
    parameters = case.scene.parameters
    names = []
    for name, value in parameters.items():
        is_nonzero_number = isinstance(value, float) and value != 0.0
        if is_nonzero_number or name in case.system.start:
            names.append(name)
    return names
