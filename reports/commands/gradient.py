"""plumbob gradient: how wrong derivatives of a method's results, or a model file's, are by way."""

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
from plumbob.reports.commands.arguments.budget import certify
from plumbob.reports.commands.arguments.model_file import described, is_file, motion
from plumbob.reports.commands.arguments.searches import search_study
from plumbob.reports.judge.gradients import study_gradients
from plumbob.reports.judge.searches import unexpected_searches
from plumbob.reports.view.tables import table
from plumbob.reports.view.terminal import aligned

if TYPE_CHECKING:
    from plumbob.engines.audit.gradient import CertifiedGradient
    from plumbob.engines.audit.reference import Certificate
    from plumbob.engines.own_motion import OwnModel, Script

INCOMPLETE = 3
OF_SCENES = ("way", "step", "eps", "at", "jobs", "changes")  # options no file has


def command(chosen: argparse.Namespace) -> int:
    """Measure, print and judge derivatives; 1 where one is not as expected."""
    if is_file(chosen, OF_SCENES):
        return _of_file(chosen)
    if not chosen.method:
        raise ParameterError("method", None, "given: engine/name")
    changed = chosen.changes
    methods = [find_method(name) for name in dict.fromkeys(chosen.method)]
    with values.representable(changed, chosen):
        case = case_of(find_scene(chosen.scene, changed))
        certify(case, chosen.at or case.scene.duration, chosen.budget)
        searches = [s for method in methods for s in _searches(chosen, case, method, changed)]
        judged = list(study_gradients(search_study(chosen, methods, searches)))
    records = [of.record() for of in judged]
    shown = aligned(table("gradients", records=records))
    values.show(chosen, records, "gradient", rows=shown, judged=judged)
    if unexpected_searches(judged):
        return 1
    missing = dict.fromkeys(e.package for m in methods if not installed(e := engine_of(m)))
    for package in missing:
        print(f"{package} is not installed", file=sys.stderr)
    return INCOMPLETE if missing else 0


def _of_file(chosen: argparse.Namespace) -> int:
    """Print derivatives of joint coordinates at the end of the motion of a model file, by its start
    and controls. Returns 3 if the method's engine is missing or cannot express the file, or if none
    of the derivatives that are asked for is both certified and given by a way."""
    from plumbob.engines.audit.gradient import numbers_of
    from plumbob.engines.audit.user_models import quiet
    from plumbob.engines.study.provenance import version_of
    from plumbob.reports.commands.arguments.console import note, progress
    from plumbob.reports.view.audit.page import versions
    from plumbob.reports.view.audit.records import gradient_record

    with quiet(), progress() as show:
        model, script = motion(chosen)
        method, model = _method_of_file(chosen, model)
        of = _matching("of", chosen.of, model.names["position"])
        by = _matching("by", chosen.by, numbers_of(model))
        try:
            reference, gradient = _gradient_of_file(
                chosen, method, model, script, lambda part: show(part, 0, 0)
            )
        except Unsupported as reason:
            note(str(reason))
            return INCOMPLETE
    asked = {"gradient": gradient.between(of, by)} if chosen.of or chosen.by else {}
    engine = engine_of(method)
    answer = {
        **described(chosen, script, reference, reference.known),
        "method": method.name,
        "step": model.step,
        **gradient_record(gradient),
        **asked,
        "versions": {**versions(), engine.name: version_of(engine)},
    }
    shown = aligned(table("file_gradients", entries=answer["gradient"]))
    values.show(chosen, answer, "gradient_file", rows=shown, known=gradient, **answer)
    compared = (
        math.isfinite(entry["exact"]) and entry["computed"] is not None
        for entry in answer["gradient"]
    )
    return 0 if any(compared) else INCOMPLETE


def _gradient_of_file(
    chosen: argparse.Namespace,
    method: Method,
    model: OwnModel,
    script: Script,
    show: Callable[[str], None],
) -> tuple[Certificate, CertifiedGradient]:
    """The certified motion of a model file and the derivatives of its end, certified and by a
    method. Raises Unsupported if there are none, with the whole sentence that says why."""
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
        more = Allowance(chosen.budget, progress=show)
        gradient = certified_gradient(model, script, reference, reference.known, more, method)
    except NotCertifiable as why:
        what = f"{chosen.scene} has no derivatives that are certified"
        raise Unsupported(f"{what}: {why}") from None
    except Unsupported as why:
        raise Unsupported(f"{method.name} does not run {chosen.scene}: {why}") from None
    return reference, gradient


def _method_of_file(chosen: argparse.Namespace, model: OwnModel) -> tuple[Method, OwnModel]:
    """The method that a command line names for a model file, and the model with the integrator of a
    method of MuJoCo's; the model's own integrator if none is named. Raises ParameterError."""
    from plumbob.engines.audit.step_of_method import DISCRETE, runs_of

    names = chosen.method or [f"mujoco/{model.integrator}"]
    if len(names) > 1:
        raise ParameterError("method", names, "one method, with a model file")
    method = find_method(names[0])
    run = runs_of(method, (*model.steppable, DISCRETE))
    return method, model if run == method.name else replace(model, integrator=run)


def _matching(option: str, text: str | None, names: Sequence[str]) -> list[str]:
    """The names that an option means, all without it: each in full, or the kind or the name alone;
    raises ParameterError."""
    if not text:
        return list(names)
    meant = list[str]()
    for word in text.split(","):
        found = [n for n in names if word in (n, n.partition(" ")[0], n.partition(" ")[2])]
        if not found:
            raise ParameterError(option, word, f"one of {nearest(word, names)}")
        meant += found
    return list(dict.fromkeys(meant))


def _searches(
    chosen: argparse.Namespace, case: Case, method: Method, changed: dict[str, object]
) -> list[GradientSearch]:
    """A search for each parameter and step; raises ParameterError."""
    from plumbob.models.gradient import numbers

    scene = case.scene
    if not meant(method, scene):
        raise ParameterError("method", method.name, f"one that is meant for {scene.name}")
    of = (
        chosen.of.split(",")
        if chosen.of
        else [q.observable for q in case.system.quantities(case)]
    )
    by = chosen.by.split(",") if chosen.by else _usual(case)
    for name in by:
        next(numbers(case, name))
    search = GradientSearch(
        scene.name,
        method.name,
        tuple(dict.fromkeys(of)),
        "",
        tuple(dict.fromkeys(chosen.way or ())),
        None,
        tuple(chosen.eps or ()),
        chosen.at,
        tuple(hashable(changed).items()),
    )
    search.check(case)
    every = product(dict.fromkeys(by), dict.fromkeys(chosen.step or (None,)))
    return [replace(search, by=name, step=step) for name, step in every]


def _usual(case: Case) -> list[str]:
    """The start, and the numbers of a scene that are not 0."""
    parameters = case.scene.parameters
    floats = [name for name, value in parameters.items() if isinstance(value, float) and value]
    return [name for name in parameters if name in floats or name in case.system.start]
