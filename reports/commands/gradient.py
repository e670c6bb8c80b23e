"""plumbob gradient: how wrong derivatives of a method's results, or a model file's, are by way."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

from plumbob.analytic.parameters import ParameterError, nearest
from plumbob.engines.method import Method, meant
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.codec import hashable
from plumbob.engines.study.gradient import GradientSearch
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.budget import certify
from plumbob.reports.commands.own_file import described, is_file, motion
from plumbob.reports.commands.stability import measured
from plumbob.reports.judge.gradients import study_gradients
from plumbob.reports.judge.searches import unexpected
from plumbob.reports.view.tables import table
from plumbob.reports.view.terminal import aligned

INCOMPLETE = 3
OF_SCENES = ("method", "way", "step", "eps", "at", "jobs", "changes")  # options no file has


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
        judged = list(study_gradients(measured(chosen, methods, searches)))
    records = [of.record() for of in judged]
    shown = aligned(table("gradients", records=records))
    values.show(chosen, records, "gradient", rows=shown, judged=judged)
    if unexpected(judged):
        return 1
    missing = dict.fromkeys(e.package for m in methods if not installed(e := engine_of(m)))
    for package in missing:
        print(f"{package} is not installed", file=sys.stderr)
    return INCOMPLETE if missing else 0


def _of_file(chosen: argparse.Namespace) -> int:
    """Print derivatives of joint coordinates at the end of the motion of a model file, by its start
    and controls: 3 where none of those that are asked for is certified."""
    from plumbob.engines.audit.allowance import Allowance
    from plumbob.engines.audit.audit import REFERENCE
    from plumbob.engines.audit.gradient import gradients, numbers_of
    from plumbob.engines.audit.reference import certified
    from plumbob.engines.audit.user_models import quiet
    from plumbob.engines.own_motion import NotCertifiable
    from plumbob.reports.commands.validate import noted, progress
    from plumbob.reports.view.audit.page import package_versions
    from plumbob.reports.view.audit.records import gradient_record

    with quiet(), progress() as show:
        model, script = motion(chosen)
        numbers = numbers_of(model)
        of = _matching("of", chosen.of, model.names["position"])
        by = _matching("by", chosen.by, numbers)
        allowance = Allowance(chosen.budget, progress=lambda what: show(what, 0, 0))
        reference = certified(model, script, allowance.part(REFERENCE))
        try:
            more = Allowance(chosen.budget, progress=allowance.progress)
            known = gradients(model, script, reference, reference.known, more)
        except NotCertifiable as why:
            noted(f"{chosen.scene} has no derivatives that are certified: {why}")
            return INCOMPLETE
    asked = {"gradient": known.between(of, by)} if chosen.of or chosen.by else {}
    answer = {
        **described(chosen, script, reference, reference.known),
        "step": model.step,
        **gradient_record(known),
        **asked,
        "versions": package_versions(),
    }
    shown = aligned(table("file_gradients", entries=answer["gradient"]))
    values.show(chosen, answer, "gradient_file", rows=shown, known=known, **answer)
    there = any(math.isfinite(entry["exact"]) for entry in answer["gradient"])
    return 0 if there else INCOMPLETE


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
