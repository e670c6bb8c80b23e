"""plumbob audit: how wrong a MuJoCo model of one's own is at its own step, and what to choose."""

from __future__ import annotations

import argparse
import json
import math
import os
import pkgutil
import sys
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, cast

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.changes import changes
from plumbob.engines.audit.contacts import SPEED, ContactAudit
from plumbob.engines.audit.controls import KINDS
from plumbob.engines.audit.engines import readers
from plumbob.engines.audit.environments import environment
from plumbob.engines.audit.trims import tried
from plumbob.engines.audit.user_models import quiet, user_models
from plumbob.engines.own_motion import AS_IT_STANDS, Policy, Start
from plumbob.models.border import must_be, regular_file
from plumbob.models.entry_points import on_stderr
from plumbob.reports.audit_from_python import BUDGET, audit, audit_contacts
from plumbob.reports.commands import several_audits
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.own_file import controls_of
from plumbob.reports.commands.several_audits import Row, model_files, page_names, refused
from plumbob.reports.view.audit.page import answer_lines, audit_answer, page
from plumbob.reports.view.audit.records import record
from plumbob.reports.view.content import Finding
from plumbob.reports.view.own_files import check_replaceable
from plumbob.reports.view.page import write_file

MISSING = 3
LARGEST_OLD = 100_000_000  # [bytes] of audits that --against reads
MISSED = 1  # an accuracy, stability or reference that is asked for
OTHER = (".urdf", ".mjb")  # models that are no text to trim
PATIENCE = 10.0  # times the budget of processor time, after which an audit of several hangs
# Options of one audit, which the other does not take, and of a file, which no environment does.
OF_MOTION = (
    "qpos",
    "qvel",
    "ctrl",
    "policy",
    "ctrl_period",
    "duration",
    "budget",
    "jobs",
    "write_trimmed",
    "stable",
    "require_reference",
    "gradient",
    "engines",
    "against",
)
OF_CONTACTS = ("body", "speed", "friction")
OF_FILES = ("model", "keyframe", "qpos", "qvel", "ctrl_period", "contacts")


def command(chosen: argparse.Namespace) -> int:
    """Print the audits; returns 1 where an accuracy, stability or reference that is asked for is
    missed."""
    from plumbob.reports.commands.arguments.console import progress

    _checked(chosen)
    files, others = (
        model_files(chosen.model, chosen.models_only) if not chosen.gym else (None, [])
    )
    if files == []:
        _note_skipped(others)
        if chosen.json:
            values.print_json([])
        return 0
    chosen.alone = files is None
    models = files or [Path(chosen.gym or chosen.model[0])]
    began = time.time()
    done = list[Row]()
    audited = partial(_audited, chosen=chosen, pages=_pages(chosen, models))
    _note_skipped(others)
    with progress() as show:
        if files is None:
            try:
                model = environment(chosen.gym, chosen.seed) if chosen.gym else models[0]
            except ImportError as why:
                print(f"plumbob: {why}: pip install 'plumbob[robots]'", file=sys.stderr)
                return MISSING
            shown: dict[str, Any] = {"progress": lambda what: show(what, 0, 0)}
            if not chosen.json:
                shown["begun"] = partial(_first_line, chosen=chosen)
            rows = iter([audited(model, jobs=chosen.jobs, **shown)])
        else:
            limit = PATIENCE * chosen.budget
            rows = several_audits.audited(files, audited, chosen.jobs, limit)
        for row in rows:
            done.append(row)
            if not chosen.alone:
                show(f"{row.path} audited", len(done), len(models))
    _report(several_audits.sorted_rows(done), chosen, began)
    return max(row.code for row in done)


def _pages(chosen: argparse.Namespace, models: Sequence[Path]) -> dict[str, str]:
    """The file names of the audits' pages by model. Raises ParameterError if a file asked for
    cannot be written, or if a single model is no regular file: before anything is audited."""
    if chosen.write_trimmed and (not chosen.alone or chosen.gym or models[0].suffix in OTHER):
        what = "left out, but with a single MJCF file"
        raise ParameterError("write trimmed", chosen.write_trimmed, what)
    ending = "-contacts.html" if chosen.contacts else ".html"
    pages = {path: f"{name}{ending}" for path, name in page_names(models).items()}
    several = [] if chosen.alone else [several_audits.PAGE]
    _writable(chosen, models, [*pages.values(), *several])
    if chosen.alone and not chosen.gym:
        regular_file("model", models[0], math.inf)
    return pages


def _note_skipped(others: Sequence[Path]) -> None:
    """Say in one line how many files of a folder are not models."""
    from plumbob.reports.commands.arguments.console import note

    if others:
        note(f"{len(others)} files are no models and are skipped, such as {others[0]}")


def _first_line(audit: Audit, chosen: argparse.Namespace) -> None:
    """Print what is audited before the audit begins, also into a pipe or a file."""
    print(answer_lines(audit_answer(_called(audit, chosen)))[0], flush=True)


def _called(audit: Audit, chosen: argparse.Namespace) -> Audit:
    """An audit with the names of its environment and of the file of its control."""
    control = audit.control if chosen.ctrl in KINDS else Path(chosen.ctrl).name
    return replace(audit, name=chosen.gym or audit.name, control=control)


def _report(done: Sequence[Row], chosen: argparse.Namespace, began: float) -> None:
    """Print and write all audits: of one file, if `chosen.alone`, or of several."""
    alone = chosen.alone
    if chosen.out is not None and not alone:
        out = Path(chosen.out)
        seconds = time.time() - began
        print(several_audits.write_page(done, out, chosen.line, seconds), file=sys.stderr)
    elif chosen.out is not None and done[0].page:
        print(Path(chosen.out) / done[0].page, file=sys.stderr)
    if chosen.junitxml:
        several_audits.write_junit(Path(chosen.junitxml), done, began)
    if chosen.badge:
        several_audits.write_badge(Path(chosen.badge), done, chosen.absolute is not None)
    if not alone and chosen.json:
        values.print_json([{**row.data, "path": row.path} for row in done])
    elif chosen.json and done[0].lines:
        values.print_json(done[0].data)
    else:
        printed = 0 if chosen.contacts else 1  # a motion's first line, since the beginning
        for line in done[0].lines[printed:] if alone else several_audits.lines(done):
            print(line)
    if chosen.github:
        marks = (mark for row in done for mark in several_audits.workflow_commands(row))
        print(*marks, sep="\n", file=sys.stderr)
    for row in done:
        if row.missed or (alone and row.code):
            print("plumbob:", *(row.missed or row.says).split(), file=sys.stderr)


def _checked(chosen: argparse.Namespace) -> None:
    """Fill in what is left out; raises ParameterError for what does not fit."""
    if chosen.policy is not None and chosen.ctrl != "rest":
        raise ParameterError("ctrl", chosen.ctrl, "left out with --policy")
    if chosen.fail_above is not None and chosen.against is None:
        raise ParameterError("fail-above", chosen.fail_above, "given with --against")
    if chosen.gym:
        values.without(chosen, OF_FILES, "left out with --gym")
        chosen.seed = values.count("seed", chosen.seed or "0", 0)
    elif chosen.seed is not None:
        raise ParameterError("seed", chosen.seed, "given with --gym")
    elif not (chosen.model and all(chosen.model)):
        raise ParameterError("model", chosen.model or None, "a file, or --gym in its place")
    if chosen.contacts:
        values.without(chosen, OF_MOTION, "left out with --contacts")
    else:
        values.without(chosen, OF_CONTACTS, "given with --contacts")
    chosen.budget = chosen.budget or BUDGET
    chosen.jobs = chosen.jobs or 1
    if chosen.write_trimmed is not None:
        new_file(Path(chosen.write_trimmed))
    if chosen.against is not None:
        chosen.against = stored_audits(Path(chosen.against))


def _writable(
    chosen: argparse.Namespace, models: Sequence[Path], pages: Collection[str]
) -> None:
    """Raises ParameterError if one of the `pages` or another file asked for cannot be written, or
    would replace one of the `models` or another file that plumbob has not written."""
    from plumbob.reports.commands.arguments.console import writable_folder

    taken = {Path(os.path.realpath(path)) for path in models}
    for name in ("junitxml", "badge"):
        if file := getattr(chosen, name):
            target = check_replaceable(name, Path(file))
            if target in taken:
                raise ParameterError(name, file, "neither a model nor another file asked for")
            taken.add(target)
            writable_folder(name, target.parent)
    if chosen.out is not None:
        out = Path(chosen.out)
        for page_name in pages:
            check_replaceable("out", out / page_name)
        writable_folder(
            "out", next(folder for folder in (out, *out.parents) if folder.exists())
        )


def _audited(
    model: Any,
    chosen: argparse.Namespace,
    pages: Mapping[str, str],
    jobs: int = 1,
    **shown: Any,
) -> Row:
    """All that is printed of the audit of a file, or environment, its page written where one is
    wanted, by the name that `pages` has for it; or why it has none."""
    path = chosen.gym or str(model)
    try:
        result = _result(model, path, chosen, jobs, **shown)
        answer = audit_answer(result)
        missed = "; ".join(_missed(result, chosen))
        name = "" if chosen.out is None else _written(answer, result, pages[path], chosen)
    except ParameterError as why:
        return refused(path, str(why))
    data = record(result)
    error = result.error(result.own[0]) if isinstance(result, ContactAudit) else result.error
    return Row(
        path,
        None if math.isnan(error) else error,
        result.step,
        data.get("to_do", ""),
        MISSED if missed else 0,
        data,
        name,
        missed,
        tuple(answer_lines(answer)),
        result.seconds,
    )


def _written(
    answer: Finding,
    result: Audit | ContactAudit,
    name: str,
    chosen: argparse.Namespace,
) -> str:
    """The name of the page of an audit, written; raises ParameterError where it cannot be."""
    from plumbob.reports.analyses.replay.geoms import audit_replay

    shown = audit_replay(result) if isinstance(result, Audit) else None
    try:
        write_file(page(answer, result, chosen.line, shown), Path(chosen.out), name)
    except OSError as error:
        what = f"a folder to write into ({error})"
        raise ParameterError("out", chosen.out, what) from None
    return name


def _result(
    model: Any,
    path: str,
    chosen: argparse.Namespace,
    jobs: int,
    **shown: Any,
) -> Audit | ContactAudit:
    """The audit of one file, or environment, of which `audit` calls what is `shown`; raises
    ParameterError."""
    if chosen.contacts:
        return audit_contacts(
            model,
            speed=chosen.speed or SPEED,
            body=chosen.body,
            friction=chosen.friction,
            keyframe=chosen.keyframe,
        )
    old = None if chosen.against is None else audit_of(Path(path), chosen.against, chosen.alone)
    begun = {name: getattr(chosen, name) for name in ("keyframe", "qpos", "qvel")}
    result: Audit = audit(
        model,
        chosen.ctrl if chosen.ctrl in KINDS else controls_of(Path(chosen.ctrl)),
        **begun,
        duration=chosen.duration,
        period=chosen.ctrl_period,
        budget=chosen.budget,
        jobs=jobs,
        gradient=chosen.gradient,
        policy=None if chosen.policy is None else policy_of(chosen.policy),
        engines=engines_of(chosen.engines),
        **shown,
    )
    result = _called(result, chosen)
    if chosen.write_trimmed is not None:
        result = trimmed_file(result, model, Path(chosen.write_trimmed), Start(**begun))
    return result if old is None else replace(result, changes=changes(old, record(result)))


def _missed(result: Audit | ContactAudit, chosen: argparse.Namespace) -> Iterator[str]:
    """Why what is asked for is missed."""
    asked = {"assert_stable": chosen.stable, "assert_referenced": chosen.require_reference}
    held: list[Callable[[], None]] = [getattr(result, name) for name in asked if asked[name]]
    if chosen.absolute is not None:
        held.append(partial(result.assert_within, chosen.absolute))
    for check in held:
        try:
            check()
        except AssertionError as why:
            yield str(why)
    # lost: infinite
    above = sys.float_info.max if chosen.fail_above is None else chosen.fail_above
    for moved in getattr(result, "changes", None) or ():
        if (moved.growth or 0.0) > above:
            yield f"{result.name}: {moved.what} {moved.old} -> {moved.new}"


def stored_audits(file: Path) -> list[Any]:
    """The audits of motions in a file, as --json printed them; raises ParameterError."""
    what = "a file that this `plumbob audit --json` has printed"
    regular_file("against", file, LARGEST_OLD)
    with must_be(what, "against", str(file)):
        content = json.loads(file.read_text("utf-8"), parse_int=float)
        stored: list[Any] = content if isinstance(content, list) else [content]
        for old in stored:
            Path(old.get("path", old["model"])).exists()
            changes(old, old)  # reads all that a comparison will
        return stored


def audit_of(file: Path, stored: Sequence[Mapping[str, Any]], alone: bool) -> Mapping[str, Any]:
    """The audit of a file among those that are `stored`: by its path, else its name, or the only
    one, of a file that is `alone`, too; raises ParameterError."""
    paths = [Path(old.get("path", old.get("model", ""))) for old in stored]
    by_path = [path == file for path in paths]
    by_name = [path.name == file.name for path in paths]
    for same in (by_path, by_name, [alone] * len(stored)):
        if sum(same) == 1:
            return stored[same.index(True)]
    raise ParameterError("against", str(file), "a model whose audit is in that file")


def engines_of(names: str | None) -> tuple[str, ...]:
    """The engines of a list of names with commas, or `all` that are installed."""
    return readers() if names == "all" else tuple(filter(None, (names or "").split(",")))


def new_file(target: Path) -> None:
    """Raises ParameterError where no file can be written, or one is there."""
    what = "an .xml file that does not exist yet, in a folder that can be written to"
    try:
        if target.suffix != ".xml":
            raise ParameterError("write trimmed", str(target), what)
        target.touch(exist_ok=False)
        target.unlink()
    except OSError as error:
        what += f" ({error.strerror})"
        raise ParameterError("write trimmed", str(target), what) from None


@quiet()
def trimmed_file(
    audit: Audit, source: Path, target: Path, start: Start = AS_IT_STANDS
) -> Audit:
    """Write the model `source` without what `audit` leaves out, and run it as it is read back;
    raises ParameterError where nothing is, or it cannot be written."""
    together = audit.trims.together if audit.trims else None
    models = user_models()
    if together is None or audit.found is None:
        raise ParameterError(
            "write trimmed", str(target), "left out: nothing of the model can go"
        )
    left_out = models.write_trimmed(source, together.changes, target)
    offered = [(left_out, models.model(target, start))]
    steps = audit.found
    (read_back,) = tried(audit.model, audit.script, steps.own.parts, steps.index, offered)
    return replace(audit, written=(target.name, read_back))


def policy_of(name: str) -> Policy:
    """The function MODULE:FUNCTION, also of a module in the present folder; raises
    ParameterError."""
    sys.path.insert(0, os.getcwd())
    try:
        with must_be("MODULE:FUNCTION", "policy", name), on_stderr():
            found = pkgutil.resolve_name(name)
    finally:
        sys.path.remove(os.getcwd())
    if not callable(found):
        raise ParameterError(
            "policy", name, "MODULE:FUNCTION, a function of time, qpos and qvel"
        )
    return cast(Policy, found)
