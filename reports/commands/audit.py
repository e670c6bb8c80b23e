"""plumbob audit: the error of your MuJoCo model at its own step, and what to choose."""

from __future__ import annotations

import argparse
import json
import math
import os
import shutil
import sys
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.changes import audited_file, changes
from plumbob.engines.audit.contacts import SPEED, ContactAudit
from plumbob.engines.audit.engines import readers
from plumbob.engines.audit.environments import environment
from plumbob.engines.audit.episodes import START_SPREAD, EpisodePlan, NamedMetric
from plumbob.engines.audit.first_verdict import affordable, first_verdict
from plumbob.engines.audit.holds import CREEP_WANTED, HoldsAudit
from plumbob.engines.audit.trims import TrimmedFile, effects_of_changes
from plumbob.engines.audit.user_models import quiet, user_models
from plumbob.engines.closed_loop import load_policy
from plumbob.engines.difference.port_repetitions import ports
from plumbob.engines.difference.repetitions import RepeatedMotion
from plumbob.engines.own_motion import AS_IT_STANDS, Start
from plumbob.models.border import must_be, regular_file
from plumbob.models.extras import install_command
from plumbob.reports.advice.fixed_file import (
    NothingToFix,
    check_fixable,
    check_new_file,
    write_fixed_file,
)
from plumbob.reports.audit_from_python import (
    AUDIT_SECONDS,
    audit,
    audit_contacts,
    audit_holds,
    audit_reproducible,
)
from plumbob.reports.columns.audit_columns import audit_columns
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.shared import several_audits
from plumbob.reports.commands.shared.audit_shards import (
    audit_shard_file,
    shard_of_files,
    write_audit_shard,
)
from plumbob.reports.commands.shared.model_file import chosen_control, control_name
from plumbob.reports.commands.shared.several_audits import (
    Row,
    model_files,
    page_names,
    refused_row,
)
from plumbob.reports.commands.shared.shards import check_shard_options, print_shard
from plumbob.reports.records.plain_data import json_text
from plumbob.reports.view.audit.html import audit_html
from plumbob.reports.view.audit.page import (
    AnyAudit,
    answer_lines,
    audit_answer,
    audit_page,
    short_lines,
)
from plumbob.reports.view.audit.records import fixed_record, record
from plumbob.reports.view.content import Finding
from plumbob.reports.view.own_files import check_replaceable
from plumbob.reports.view.page import write_file
from plumbob.reports.view.tables import terminal_lines

MISSING = 3
WRITE_FIXED = "write fixed"
NO_EPISODES = "given with --episodes"
LARGEST_AUDITS = 100_000_000  # [bytes] largest file that --against reads
MISSED = 1  # exit code: a required accuracy, stability or reference is missed
UNTRIMMABLE = (".urdf", ".mjb")  # formats of models that --write-trimmed does not take
# An audit of several that takes this many times its budget of processor time counts as hung.
PATIENCE = 10.0
# Options of the audit of a motion, of the audit of contacts, and of files; the other audit, or an
# environment, does not take them.
MOTION_OPTIONS = (
    "qpos",
    "qvel",
    "ctrl",
    "policy",
    "in_the_loop",
    "episodes",
    "metric",
    "spread",
    "return_within",
    "ctrl_period",
    "duration",
    "budget",
    "jobs",
    "write_trimmed",
    "write_fixed",
    "stable",
    "require_reference",
    "gradient",
    "engines",
    "against",
)
LEAST_COLUMNS, MOST_COLUMNS = 60, 120  # width of the short answer on a terminal
# Options whose results stand in lines that the short answer lacks.
IN_ALL_LINES = (
    "verbose",
    "against",
    "gradient",
    "engines",
    "write_trimmed",
    "in_the_loop",
    "episodes",
)
# Options of the audit of a motion that --reproducible takes too; it has no certified motion
REPEATED_OPTIONS = (
    *("qpos", "qvel", "ctrl", "policy", "ctrl_period", "duration", "budget", "jobs", "engines"),
)
# Outputs that show the error of a motion
ERROR_OUTPUTS = ("badge", "csv", "latex")
CONTACT_AUDIT_OPTIONS = ("body", "speed", "friction")
HOLDS_OPTIONS = ("holds_body", "creep_within")
# Options that all shards of the audits of several models have to share.
SHARED_BY_SHARDS = (
    *(name for name in MOTION_OPTIONS if name != "jobs"),
    *CONTACT_AUDIT_OPTIONS,
    *HOLDS_OPTIONS,
    "keyframe",
    "contacts",
    "holds",
    "reproducible",
    "absolute",
    "fail_above",
)
FILE_OPTIONS = (
    "model",
    "keyframe",
    "qpos",
    "qvel",
    "ctrl_period",
    "contacts",
    "holds",
    "reproducible",
    "metric",
    "spread",
)
FIRST_PART = 0.25  # largest part of the budget for the runs of the first verdict
EPISODES = "episodes.sqlite3"  # file in the folder --out with the outcomes of episodes


@dataclass(frozen=True)
class PrintedFix:
    """The lines and the record that are printed of a fixed file, and its missed requirements."""

    lines: tuple[str, ...]
    record: Mapping[str, Any] | None  # None if the file is not written
    missed: list[str]


def command(chosen: argparse.Namespace) -> int:
    """Audits the models, prints and writes the audits, and returns the exit code: 1 if an accuracy,
    a stability or a reference that the user asks for is missed."""
    from plumbob.reports.commands.arguments.console import progress

    check_shard_options(chosen)
    _check_arguments(chosen)
    files: list[Path] | None = None
    skipped: list[Path] = []
    if not chosen.gym:
        files, skipped = model_files(chosen.model, chosen.models_only)
    if files == []:
        _note_skipped(skipped)
        if values.as_table(chosen):
            values.print_table(chosen, audit_columns([]))
        elif chosen.json:
            values.print_json([])
        return 0
    chosen.alone = files is None
    if chosen.shard and files is None:
        raise ParameterError("shard", str(chosen.shard), "left out with a single model")
    models = files or [Path(chosen.gym or chosen.model[0])]
    if chosen.shard and files:
        shard_file = audit_shard_file(chosen.shard, chosen.out)
        files = shard_of_files(chosen.shard, files)
    began = time.time()
    audit_row = partial(_audit_row, chosen=chosen, pages=_page_files(chosen, models))
    _note_skipped(skipped)
    finished = list[Row]()
    estimate = list[str]()
    budget = chosen.budget if files is None else None
    with progress(budget, lines=True, above=estimate) as show:
        if files is None:
            try:
                model = environment(chosen.gym, chosen.seed) if chosen.gym else models[0]
            except ImportError as why:
                print(f"plumbob: {why}: {install_command('robots')}", file=sys.stderr)
                return MISSING
            callbacks: dict[str, Any] = {"progress": lambda part: show(part, 0, 0)}
            if not chosen.reproducible:
                callbacks["begun"] = partial(_show_first_verdict, chosen=chosen, above=estimate)
            rows = iter([audit_row(model, jobs=chosen.jobs, **callbacks)])
        else:
            limit = PATIENCE * chosen.budget
            rows = several_audits.audit_rows(files, audit_row, chosen.jobs, limit)
        for row in rows:
            finished.append(row)
            if not chosen.alone:
                show(f"{row.path} audited", len(finished), len(models))
    sorted_rows = several_audits.sorted_rows(finished)
    if chosen.shard:
        options = {name: getattr(chosen, name) for name in SHARED_BY_SHARDS}
        write_audit_shard(shard_file, chosen.shard, sorted_rows, models, options)
        print_shard(chosen, len(sorted_rows), "model")
    else:
        several_audits.write_table(sorted_rows, chosen, began)
        several_audits.print_rows(sorted_rows, chosen)
    return max((row.code for row in finished), default=0)


def _page_files(chosen: argparse.Namespace, models: Sequence[Path]) -> dict[str, str]:
    """Returns the file name of each audit's page by model. Nothing is audited before this check:
    raises ParameterError if a file that the user asks for cannot be written, or if the single model
    is no regular file."""
    single_file = chosen.alone and not chosen.gym
    if chosen.write_trimmed and not (single_file and models[0].suffix not in UNTRIMMABLE):
        expected = "left out, but with a single MJCF file"
        raise ParameterError("write trimmed", chosen.write_trimmed, expected)
    if chosen.write_fixed:
        if not single_file:
            expected = "left out, but with a single MJCF or URDF file"
            raise ParameterError(WRITE_FIXED, chosen.write_fixed, expected)
        check_fixable(models[0], Path(chosen.write_fixed))
    ending = ".html"
    for kind in ("contacts", "holds", "reproducible"):
        if getattr(chosen, kind):
            ending = f"-{kind}.html"
    pages = {path: f"{name}{ending}" for path, name in page_names(models).items()}
    written_pages = list(pages.values())
    if ending == ".html":
        written_pages += [_record_file(page_file) for page_file in pages.values()]
    if not chosen.alone:
        written_pages.append(several_audits.PAGE)
    _check_targets(chosen, models, written_pages)
    if chosen.alone and not chosen.gym:
        regular_file("model", models[0], math.inf)
    return pages


def _note_skipped(others: Sequence[Path]) -> None:
    """Says in one line on stderr how many files of a folder hold no model."""
    from plumbob.reports.commands.arguments.console import note

    if others:
        note(f"{len(others)} files are no models and are skipped, such as {others[0]}")


def _show_first_verdict(audit: Audit, chosen: argparse.Namespace, above: list[str]) -> None:
    """Prints the first line, which names the audited motion, before the audit begins, also into a
    pipe or a file. Then shows what two runs tell: on a terminal among the lines `above` the
    progress, which disappear with it, else in one line on stderr. A policy in the loop is not asked
    for it, and runs that would take more than a part of the budget are shorter, or left out."""
    from plumbob.reports.commands.arguments.console import note

    if not (chosen.json or values.as_table(chosen)):
        print(answer_lines(audit_answer(_with_given_names(audit, chosen)))[0], flush=True)
    if audit.script.loop is not None:
        return
    script = affordable(audit.model, audit.script, FIRST_PART * chosen.budget)
    if script is None:
        return
    verdict = first_verdict(audit.model, script)
    remarks = [*audit.notes, *verdict.remarks]
    lines = terminal_lines("audit_first", audit=audit, verdict=verdict, remarks=remarks)
    if sys.stderr.isatty():
        above += lines
    else:
        note("first verdict: " + "; ".join(" ".join(line.split()) for line in lines))


def _short_lines(result: AnyAudit, chosen: argparse.Namespace) -> list[str]:
    """Returns the most important lines of a motion's audit for the terminal. There are none if all
    lines are printed: the user asks for them, or for numbers that have a line of their own."""
    if not isinstance(result, Audit) or any(getattr(chosen, name) for name in IN_ALL_LINES):
        return []
    columns = min(MOST_COLUMNS, shutil.get_terminal_size().columns)
    return short_lines(result, max(LEAST_COLUMNS, columns))


def _with_given_names(audit: Audit, chosen: argparse.Namespace) -> Audit:
    """Returns `audit` with the name of its environment, and with the name of the file that gives
    its control. The control of a policy keeps the name that the audit gives it."""
    control = control_name(chosen.ctrl) if chosen.policy is None else audit.control
    return replace(audit, name=chosen.gym or audit.name, control=control)


def _check_arguments(chosen: argparse.Namespace) -> None:
    """Fills in defaults of arguments. Raises ParameterError if two arguments do not go together."""
    if chosen.policy is not None and chosen.ctrl != "rest":
        raise ParameterError("ctrl", chosen.ctrl, "left out with --policy")
    if chosen.in_the_loop and chosen.policy is None:
        raise ParameterError("in the loop", True, "given with --policy")
    for name in ("metric", "spread", "return_within"):
        if getattr(chosen, name) is not None and chosen.episodes is None:
            raise ParameterError(name.replace("_", " "), getattr(chosen, name), NO_EPISODES)
    if chosen.episodes is not None and not chosen.gym and chosen.metric is None:
        raise ParameterError("episodes", chosen.episodes, "given with --metric")
    if chosen.episodes is not None and chosen.gym and not chosen.in_the_loop:
        raise ParameterError("episodes", chosen.episodes, "given with --in-the-loop")
    if chosen.fail_above is not None and chosen.against is None:
        raise ParameterError("fail-above", chosen.fail_above, "given with --against")
    if chosen.gym:
        values.refuse_options(chosen, FILE_OPTIONS, "left out with --gym")
        chosen.seed = values.count("seed", chosen.seed or "0", 0)
    elif chosen.seed is not None:
        raise ParameterError("seed", chosen.seed, "given with --gym")
    elif not (chosen.model and all(chosen.model)):
        raise ParameterError("model", chosen.model or None, "a file, or --gym in its place")
    _check_kind(chosen)
    chosen.budget = chosen.budget or AUDIT_SECONDS
    chosen.jobs = chosen.jobs or 1
    if chosen.write_trimmed is not None:
        check_new_file("write trimmed", Path(chosen.write_trimmed), ".xml")
        if chosen.write_fixed is not None and _same_path(
            chosen.write_trimmed, chosen.write_fixed
        ):
            expected = "another file than --write-trimmed names"
            raise ParameterError(WRITE_FIXED, chosen.write_fixed, expected)
    if chosen.against is not None:
        chosen.against = read_audits(Path(chosen.against))


def _check_kind(chosen: argparse.Namespace) -> None:
    """Raises ParameterError if an option is given that this kind of audit does not take."""
    if chosen.contacts:
        values.refuse_options(chosen, (*MOTION_OPTIONS, "holds"), "left out with --contacts")
    else:
        values.refuse_options(chosen, CONTACT_AUDIT_OPTIONS, "given with --contacts")
    if chosen.holds:
        refused = [name for name in MOTION_OPTIONS if name != "qpos"]
        refused += ["absolute", *ERROR_OUTPUTS]
        values.refuse_options(chosen, refused, "left out with --holds")
    else:
        values.refuse_options(chosen, HOLDS_OPTIONS, "given with --holds")
    if chosen.reproducible:
        refused = [name for name in MOTION_OPTIONS if name not in REPEATED_OPTIONS]
        others = ("absolute", "contacts", "holds", *ERROR_OUTPUTS)
        values.refuse_options(chosen, (*refused, *others), "left out with --reproducible")


def _check_targets(
    chosen: argparse.Namespace, models: Sequence[Path], pages: Collection[str]
) -> None:
    """Raises ParameterError if one of the `pages` or another file that the user asks for cannot be
    written, or would replace a model or a file that plumbob has not written."""
    from plumbob.reports.commands.arguments.console import writable_folder

    taken = {Path(os.path.realpath(path)) for path in models}
    for name in ("junitxml", "badge"):
        file = getattr(chosen, name)
        if file:
            target = check_replaceable(name, Path(file))
            if target in taken:
                raise ParameterError(name, file, "neither a model nor another file asked for")
            taken.add(target)
            writable_folder(name, target.parent)
    if chosen.out is not None:
        out = Path(chosen.out)
        for page_name in pages:
            check_replaceable("out", out / page_name)
        existing_folder = next(folder for folder in (out, *out.parents) if folder.exists())
        writable_folder("out", existing_folder)


def _audit_row(
    model: Any,
    chosen: argparse.Namespace,
    pages: Mapping[str, str],
    jobs: int = 1,
    **callbacks: Any,
) -> Row:
    """Audits a model file or an environment, writes its page if the user asks for pages, and
    returns its row. `pages` has the names of the pages by path. If the audit is refused, the row
    has the reason."""
    path = chosen.gym or str(model)
    try:
        result = _run_audit(model, path, chosen, jobs, **callbacks)
        answer = audit_answer(result)
        missed = [*_missed_requirements(result, chosen)]
        data, lines = record(result), answer_lines(answer)
        short = _short_lines(result, chosen)
        page_name = ""
        if chosen.out is not None:
            page_name = _write_page(answer, result, pages[path], chosen)
        if chosen.write_fixed is not None and isinstance(result, Audit):
            fixed = _write_fixed(result, chosen, callbacks.get("progress", _silent))
            missed += fixed.missed
            data |= {"fixed_file": fixed.record}
            lines += fixed.lines
            if short:
                short += fixed.lines
        if page_name and isinstance(result, Audit):
            _write_into(chosen.out, json_text({**data, "path": path}), _record_file(page_name))
    except ParameterError as why:
        return refused_row(path, str(why))
    error = _error_at_own_step(result)
    undecided = isinstance(result, RepeatedMotion) and bool(result.open)
    return Row(
        path=path,
        error=None if math.isnan(error) else error,
        step=data.get("step"),
        says=result.coulomb if isinstance(result, HoldsAudit) else data.get("to_do", ""),
        code=MISSED if missed else MISSING * undecided,
        data=data,
        page=page_name,
        missed="; ".join(missed),
        lines=tuple(lines),
        short=tuple(short),
        seconds=result.seconds,
    )


def _error_at_own_step(result: AnyAudit) -> float:
    """Returns the error [m] of an audit at the model's own step; NaN if there is none."""
    if isinstance(result, (HoldsAudit, RepeatedMotion)):
        return math.nan
    return result.error(result.own[0]) if isinstance(result, ContactAudit) else result.error


def _silent(what: str) -> None:
    """Shows no progress."""


def _write_fixed(
    result: Audit, chosen: argparse.Namespace, progress: Callable[[str], None]
) -> PrintedFix:
    """Writes the advice of an audit into the file --write-fixed, audits that file, and returns what
    is printed of it. Raises ParameterError."""
    try:
        target = Path(chosen.write_fixed)
        fixed = write_fixed_file(result, target, chosen.budget, progress)
    except NothingToFix as why:
        return PrintedFix((), None, [f"{chosen.write_fixed} is not written: {why}"])
    lines = terminal_lines("audit_fixed", fixed=fixed)
    missed = [] if fixed.kept else [f"{target.name}: its error is not the promised one"]
    return PrintedFix(tuple(lines), fixed_record(fixed), missed)


def _write_page(
    answer: Finding,
    result: AnyAudit,
    name: str,
    chosen: argparse.Namespace,
) -> str:
    """Writes the page of an audit into the folder --out and returns the page's name. Raises
    ParameterError if the page cannot be written."""
    from plumbob.reports.analyses.replay.audit_motion import audit_replay

    replay = audit_replay(result) if isinstance(result, Audit) else None
    content = audit_page(answer, result, chosen.line, replay)
    _write_into(chosen.out, audit_html(content), name)
    return name


def _record_file(page_file: str) -> str:
    """Returns the name of the file with the record of an audit, beside the audit's page."""
    return str(Path(page_file).with_suffix(".json"))


def _write_into(out: str, text: str, name: str) -> None:
    """Writes a file into the folder --out; raises ParameterError if it cannot be written."""
    try:
        write_file(text, Path(out), name)
    except OSError as error:
        expected = f"a folder to write into ({error})"
        raise ParameterError("out", out, expected) from None


def _run_audit(
    model: Any,
    path: str,
    chosen: argparse.Namespace,
    jobs: int,
    **callbacks: Any,
) -> AnyAudit:
    """Returns the audit of a model file or an environment. `callbacks` go to `audit` as they are.
    Raises ParameterError."""
    if chosen.holds:
        return audit_holds(
            model,
            body=chosen.holds_body,
            keyframe=chosen.keyframe,
            qpos=chosen.qpos,
            creep_within=chosen.creep_within or CREEP_WANTED,
        )
    if chosen.contacts:
        return audit_contacts(
            model,
            speed=chosen.speed or SPEED,
            body=chosen.body,
            friction=chosen.friction,
            keyframe=chosen.keyframe,
        )
    start = {name: getattr(chosen, name) for name in ("keyframe", "qpos", "qvel")}
    policy = None if chosen.policy is None else load_policy(chosen.policy)
    motion = {
        **start,
        "control": chosen_control(chosen.ctrl),
        "duration": chosen.duration,
        "period": chosen.ctrl_period,
        "budget": chosen.budget,
        "policy": policy,
        **callbacks,
    }
    if chosen.reproducible:
        engines = ports() if chosen.engines == "all" else engine_names(chosen.engines)
        return audit_reproducible(model, engines=engines, **motion)
    old_audit = None
    if chosen.against is not None:
        old_audit = matching_audit(Path(path), chosen.against, chosen.alone)
    result: Audit = audit(
        model,
        jobs=jobs,
        gradient=chosen.gradient,
        in_the_loop=chosen.in_the_loop,
        episodes=None if chosen.episodes is None else episode_plan(chosen),
        engines=engine_names(chosen.engines),
        **motion,
    )
    result = _with_given_names(result, chosen)
    if chosen.write_trimmed is not None:
        result = write_trimmed_file(result, model, Path(chosen.write_trimmed), Start(**start))
    if old_audit is not None:
        result = replace(result, changes=changes(old_audit, record(result)))
    return result


def _missed_requirements(result: AnyAudit, chosen: argparse.Namespace) -> Iterator[str]:
    """Gives a sentence for each requirement of the user that the audit misses."""
    requirements: list[Callable[[], None]] = []
    if isinstance(result, HoldsAudit):
        requirements.append(result.assert_holds)
        if chosen.creep_within is not None:
            requirements.append(partial(result.assert_creeps_within, chosen.creep_within))
    if isinstance(result, Audit) and chosen.stable:
        requirements.append(result.assert_stable)
    if isinstance(result, Audit) and chosen.require_reference:
        requirements.append(result.assert_referenced)
    if isinstance(result, RepeatedMotion):
        requirements.append(result.assert_reproducible)
    elif chosen.absolute is not None and not isinstance(result, HoldsAudit):
        requirements.append(partial(result.assert_within, chosen.absolute))
    if isinstance(result, Audit) and chosen.return_within is not None:
        requirements.append(partial(result.assert_return_within, chosen.return_within))
    for requirement in requirements:
        try:
            requirement()
        except AssertionError as why:
            yield str(why)
    # The growth of a value that is lost is infinite: it always counts.
    largest_growth = sys.float_info.max if chosen.fail_above is None else chosen.fail_above
    for change in getattr(result, "changes", None) or ():
        if (change.growth or 0.0) > largest_growth:
            yield f"{result.name}: {change.what} {change.old} -> {change.new}"


def read_audits(file: Path) -> list[Any]:
    """Returns the audits in a file that --json has written. Raises ParameterError."""
    expected = "a file that this `plumbob audit --json` has printed"
    regular_file("against", file, LARGEST_AUDITS)
    with must_be(expected, "against", str(file)):
        content = json.loads(file.read_text("utf-8"), parse_int=float)
        audits: list[Any] = content if isinstance(content, list) else [content]
        for stored in audits:
            # The comparison with itself fails here, not after the audit, if a value is unusable.
            Path(stored.get("path", stored["model"])).exists()
            changes(stored, stored)
        return audits


def matching_audit(
    file: Path, stored: Sequence[Mapping[str, Any]], alone: bool
) -> Mapping[str, Any]:
    """Returns the audit in `stored` that belongs to `file`: the audit with its path, or else with
    its name. If `file` is audited `alone`, a single stored audit belongs to it under any name.
    Raises ParameterError if no audit or several audits match."""
    paths = [Path(audited_file(old)) for old in stored]
    same_path = [path == file for path in paths]
    same_name = [path.name == file.name for path in paths]
    for matches in (same_path, same_name, [alone] * len(stored)):
        if sum(matches) == 1:
            return stored[matches.index(True)]
    raise ParameterError("against", str(file), "a model whose audit is in that file")


def engine_names(names: str | None) -> tuple[str, ...]:
    """Returns the names in a list with commas; all installed engines that read model files if the
    list is `all`."""
    if names == "all":
        return readers()
    return tuple(name for name in (names or "").split(",") if name)


def _same_path(first: str, second: str) -> bool:
    """Returns whether two names are those of one file."""
    return os.path.realpath(first) == os.path.realpath(second)


@quiet()
def write_trimmed_file(
    audit: Audit, source: Path, target: Path, start: Start = AS_IT_STANDS
) -> Audit:
    """Writes the model `source` into `target` without the parts that `audit` found needless.
    Returns `audit` with the errors of a run of the written file. Raises ParameterError if no part
    is needless or the file cannot be written."""
    together = audit.trims.together if audit.trims else None
    models = user_models()
    if together is None or audit.found is None:
        raise ParameterError(
            "write trimmed", str(target), "left out: nothing of the model can go"
        )
    removed = models.write_trimmed(source, together.changes, target)
    offered = [(removed, models.model(target, start))]
    steps = audit.found
    (read_back,) = effects_of_changes(
        audit.model, audit.script, steps.own.parts, steps.index, offered
    )
    return replace(audit, written=TrimmedFile(target.name, read_back))


def episode_plan(chosen: argparse.Namespace) -> EpisodePlan:
    """Returns the episodes that the user asks for, stored in the folder --out, if any. The metric
    MODULE:FUNCTION of a model, which may lie in the current folder, is loaded once as a check.
    Raises ParameterError."""
    metric = None
    if chosen.metric is not None:
        metric = NamedMetric(chosen.metric, os.getcwd())
        metric.load()
    file = None if chosen.out is None else Path(chosen.out) / EPISODES
    return EpisodePlan(chosen.episodes, metric, chosen.spread or START_SPREAD, file)
