"""plumbob audit: how wrong a MuJoCo model of one's own is at its own step, and what to choose."""

from __future__ import annotations

import argparse
import importlib
import json
import math
import os
import shlex
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, cast
from zipfile import BadZipFile

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.abilities import UserModels
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.changes import changes
from plumbob.engines.audit.contacts import SPEED, ContactAudit
from plumbob.engines.audit.controls import KINDS
from plumbob.engines.audit.engines import readers
from plumbob.engines.audit.environments import environment
from plumbob.engines.audit.trims import tried
from plumbob.engines.own_motion import AS_IT_STANDS, Policy, Start
from plumbob.engines.registry import find_engine
from plumbob.reports.audit_from_python import BUDGET, audit, audit_contacts, start_of
from plumbob.reports.commands import several_audits
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.several_audits import Row, model_files, refused
from plumbob.reports.view.audit.page import answered, lines, page, rows, write_page
from plumbob.reports.view.audit.records import record

MISSING = 3
MISSED = 1  # an accuracy, stability or reference that is asked for
OTHER = (".urdf", ".mjb")  # models that are no text to trim
PATIENCE = 10.0  # times the budget, after which an audit of several hangs
_LARGEST = 100_000_000  # bytes of a control file
# Options of one audit, which the other does not take: those that decide its numbers, and the rest.
MOTION = ("qpos", "qvel", "ctrl", "policy", "ctrl_period", "duration", "budget", "jobs")
OF_MOTION = (
    *MOTION,
    "write_trimmed",
    "stable",
    "require_reference",
    "gradient",
    "engines",
)
FILES = ("junitxml", "badge")
REFUSED = frozenset(["model", "path", "error", "why"])  # keys of a file that has no audit
OF_CONTACTS = ("body", "speed", "friction")
REPEATED = ("gym", "seed", "keyframe", *MOTION, "engines", *OF_CONTACTS)


def command(chosen: argparse.Namespace) -> int:
    """Print the audits; returns 1 where an accuracy, stability or reference that is asked for is
    missed."""
    numbers = _numbers(chosen)
    target = None if chosen.write_trimmed is None else new_file(Path(chosen.write_trimmed))
    if chosen.out is not None and Path(chosen.out).exists() and not Path(chosen.out).is_dir():
        raise ParameterError("out", chosen.out, "a folder to write into")
    _fits(chosen)
    if chosen.against is not None:
        chosen.against = stored_audits(Path(chosen.against), chosen.contacts)
    jobs = 1 if chosen.jobs is None else values.count("jobs", chosen.jobs)
    gym = None
    if chosen.gym is not None:
        try:
            gym = _environment(chosen)
        except ImportError as why:
            print(f"plumbob: {why}: pip install 'plumbob[robots]'", file=sys.stderr)
            return MISSING
    elif not chosen.model or chosen.seed is not None:
        raise ParameterError("model", chosen.model or None, "a file, or --gym with its --seed")
    files = None if gym else model_files(chosen.model)
    if target is not None and (gym or files is not None or Path(chosen.model[0]).suffix in OTHER):
        what = "left out, but with a single MJCF file"
        raise ParameterError("write trimmed", str(target), what)
    targets = _targets(chosen)
    began = time.time()
    if files is None:
        model = gym or Path(chosen.model[0])
        done = [_alone(model, chosen, numbers, jobs, target)]
    else:
        done = _several(files, chosen, numbers, jobs)
    if "junitxml" in targets:
        several_audits.write_junit(targets["junitxml"], done, began)
    if "badge" in targets:
        several_audits.write_badge(targets["badge"], done, "absolute" in numbers)
    if chosen.json:
        values.print_json(done[0].data if files is None else [row.data for row in done])
    else:
        print("\n".join(done[0].lines if files is None else several_audits.lines(done)))
    if chosen.github:
        marks = (mark for row in done for mark in several_audits.workflow_commands(row))
        print(*marks, sep="\n", file=sys.stderr)
    for row in done:
        if row.missed or (files is None and row.code):
            print(f"plumbob: {row.missed or row.says}", file=sys.stderr)
    return max(row.code for row in done)


def _targets(chosen: argparse.Namespace) -> dict[str, Path]:
    """The files that are to be written of all audits, by option; raises ParameterError."""
    from plumbob.reports.commands.validate import replaceable, writable

    targets = {}
    for name in FILES:
        if file := getattr(chosen, name):
            targets[name] = replaceable(name, Path(file))
            writable(name, targets[name].parent)
    return targets


def _numbers(chosen: argparse.Namespace) -> dict[str, float]:
    """The numbers that the options give, SI; raises ParameterError."""
    numbers = {
        name: values.positive_number(name.replace("_", " "), text)
        for name in ("ctrl_period", "duration", "absolute", "budget", "speed", "friction")
        if (text := getattr(chosen, name)) is not None
    }
    if chosen.fail_above is not None:
        numbers["fail_above"] = values.fraction("fail-above", chosen.fail_above)
    return numbers


def _environment(chosen: argparse.Namespace) -> Any:
    """The environment that is asked for; raises ParameterError, and ImportError."""
    for name in ("model", "keyframe", "qpos", "qvel", "ctrl_period", "contacts"):
        if value := getattr(chosen, name):
            raise ParameterError(name.replace("_", " "), value, "left out with --gym")
    seed = 0 if chosen.seed in (None, "0") else values.count("seed", chosen.seed)
    return environment(chosen.gym, seed)


def _alone(
    model: Any,
    chosen: argparse.Namespace,
    numbers: Mapping[str, float],
    jobs: int,
    target: Path | None,
) -> Row:
    """The audit of one file; raises ParameterError where it has none and no file holds that."""
    from plumbob.reports.commands.validate import progress

    try:
        with progress() as show:
            result = _of_file(model, chosen, numbers, jobs, lambda what: show(what, 0, 0))
        if target is not None and isinstance(result, Audit):
            result = trimmed_file(result, model, target, start_of(**start_given(chosen)))
    except ParameterError as why:
        if not any(getattr(chosen, name) for name in (*FILES, "github")):
            raise
        return refused(chosen.gym or str(model), str(why))
    row = _row(result, chosen.gym or str(model), chosen, numbers)
    if chosen.out is not None:
        print(_written(row, chosen), file=sys.stderr)
    return row


def _of_file(
    model: Any,
    chosen: argparse.Namespace,
    numbers: Mapping[str, float],
    jobs: int = 1,
    progress: Callable[[str], None] = lambda what: None,
) -> Audit | ContactAudit:
    """The audit of one file, or environment; raises ParameterError."""
    old = None if chosen.against is None else audit_of(Path(chosen.gym or model), chosen.against)
    if chosen.contacts:
        slid = audit_contacts(
            model,
            speed=numbers.get("speed", SPEED),
            body=chosen.body,
            friction=numbers.get("friction"),
            keyframe=chosen.keyframe,
        )
        return slid if old is None else replace(slid, changes=changes(old, record(slid)))
    result = audit(
        model,
        chosen.ctrl if chosen.ctrl in KINDS else controls_of(Path(chosen.ctrl)),
        **start_given(chosen),
        duration=numbers.get("duration"),
        period=numbers.get("ctrl_period"),
        budget=numbers.get("budget", BUDGET),
        jobs=jobs,
        progress=progress,
        gradient=chosen.gradient,
        policy=None if chosen.policy is None else policy_of(chosen.policy),
        engines=engines_of(chosen.engines),
    )
    result = replace(result, name=chosen.gym or result.name)
    if old is None:
        return result
    return replace(result, changes=changes(old, record(result)))


def _of_several(file: Path, chosen: argparse.Namespace, numbers: Mapping[str, float]) -> Row:
    """The audit of one file of several, which costs its own row where there is none."""
    try:
        row = _row(_of_file(file, chosen, numbers), str(file), chosen, numbers)
    except ParameterError as why:
        return refused(str(file), str(why))
    return replace(row, data={**row.data, "path": str(file)})


def _row(
    result: Audit | ContactAudit,
    path: str,
    chosen: argparse.Namespace,
    numbers: Mapping[str, float],
) -> Row:
    """All that is printed and written of an audit, its page where one is wanted."""
    answer, missed = answered(result), list(_missed(result, chosen, numbers))
    error = result.error(result.own[0]) if isinstance(result, ContactAudit) else result.error
    text = ""
    if chosen.out is not None:
        from plumbob.reports.analyses.replay.geoms import audited

        shown = audited(result) if isinstance(result, Audit) else None
        text = page(answer, result, _command(chosen, [path] * (chosen.gym is None)), shown)
    return Row(
        path,
        None if math.isnan(error) else error,
        result.step,
        dict(rows(answer)).get("to do", ""),
        MISSED if missed else 0,
        record(result),
        text,
        "; ".join(missed),
        tuple(lines(answer)),
        result.seconds,
    )


def _several(
    files: Sequence[Path], chosen: argparse.Namespace, numbers: Mapping[str, float], jobs: int
) -> list[Row]:
    """Several audits, the largest error first, with their page where one is wanted."""
    from plumbob.reports.commands.validate import progress

    began, done = time.monotonic(), list[Row]()
    limit = PATIENCE * numbers.get("budget", BUDGET)
    audited = partial(_of_several, chosen=chosen, numbers=numbers)
    with progress() as show:
        try:
            for row in several_audits.audited(files, audited, jobs, limit):
                done.append(row)
                show(f"{row.path} audited", len(done), len(files))
        except KeyboardInterrupt:  # what is done is not lost
            print("\n".join(several_audits.lines(several_audits.sorted_rows(done))))
            raise
        finally:  # in the order of paths: files of one name have names that do not depend on time
            done = [
                replace(row, page=_written(row, chosen).name) if row.page else row
                for row in sorted(done, key=lambda row: row.path)
            ]
    done = several_audits.sorted_rows(done)
    if chosen.out is not None:
        command = _command(chosen, chosen.model)
        seconds = time.monotonic() - began
        print(several_audits.write_page(done, Path(chosen.out), command, seconds), file=sys.stderr)
    return done


def _missed(
    result: Audit | ContactAudit, chosen: argparse.Namespace, numbers: Mapping[str, float]
) -> Iterator[str]:
    """Why what is asked for is missed."""
    metres, above = numbers.get("absolute"), numbers.get("fail_above", math.inf)
    held: list[Callable[[], None]] = []
    if isinstance(result, Audit):
        held += [result.assert_stable] * chosen.stable
        held += [result.assert_referenced] * chosen.require_reference
    if metres is not None:
        held.append(partial(result.assert_within, metres))
    for check in held:
        try:
            check()
        except AssertionError as why:
            yield str(why)
    for moved in result.changes or ():
        if moved.growth is not None and (moved.growth > above or moved.growth == above == math.inf):
            yield f"{result.name}: {moved.what} {moved.old} -> {moved.new}"


def _fits(chosen: argparse.Namespace) -> None:
    """Raises ParameterError for an option of one audit that is given to the other, or that does
    not go with another option."""
    if chosen.policy is not None and chosen.ctrl != "rest":
        raise ParameterError("ctrl", chosen.ctrl, "left out with --policy")
    if chosen.fail_above is not None and chosen.against is None:
        raise ParameterError("fail-above", chosen.fail_above, "given with --against")
    for name in OF_MOTION if chosen.contacts else OF_CONTACTS:
        value = getattr(chosen, name)
        if value and value != "rest":
            what = "left out with --contacts" if chosen.contacts else "given with --contacts"
            raise ParameterError(name.replace("_", " "), value, what)


def _written(row: Row, chosen: argparse.Namespace) -> Path:
    """The page of an audit, written; raises ParameterError where it cannot be."""
    folder = Path(chosen.out)
    try:
        return write_page(row.page, row.path, folder, chosen.contacts)
    except OSError as error:
        raise ParameterError("out", str(folder), f"a folder to write into ({error})") from None


def _command(chosen: argparse.Namespace, files: Sequence[str]) -> str:
    """The command that repeats an audit of `files`."""
    given = [(o, getattr(chosen, o)) for o in REPEATED]
    words = [*files]
    words += [f"--{o.replace('_', '-')}={v}" for o, v in given if v and v != "rest"]
    words += ["--contacts"] * chosen.contacts + ["--gradient"] * chosen.gradient
    return f"plumbob audit {shlex.join([*words, '--out', chosen.out])}"


def stored_audits(file: Path, contacts: bool) -> list[Any]:
    """The audits in a file, as --json printed them, of `contacts` or of motions; raises
    ParameterError."""
    what = "a file that `plumbob audit --json` has printed"
    if not file.is_file() or file.stat().st_size > _LARGEST:
        raise ParameterError("against", str(file), what)
    try:
        stored = json.loads(file.read_text("utf-8"))
    except (ValueError, RecursionError) as error:
        raise ParameterError("against", str(file), f"{what} ({error})") from None
    stored = stored if isinstance(stored, list) else [stored]
    kind = {"own", "compared_with"} if contacts else {"fields", "error_over_time"}
    if not all(isinstance(o, dict) and (kind <= {*o} or {*o} == REFUSED) for o in stored):
        raise ParameterError("against", str(file), f"{what}{' --contacts' * contacts}")
    return stored


def audit_of(file: Path, stored: Sequence[Mapping[str, Any]]) -> Mapping[str, Any]:
    """The audit of a file among those that are `stored`: by its path, else its name, or the only
    one; raises ParameterError."""
    paths = [Path(old.get("path", old.get("model", ""))) for old in stored]
    of_path = [old for old, path in zip(stored, paths, strict=True) if path == file]
    of_name = [old for old, path in zip(stored, paths, strict=True) if path.name == file.name]
    for candidates in (of_path, of_name, stored):
        if len(candidates) == 1:
            return candidates[0]
    raise ParameterError("against", str(file), "a model whose audit is in that file")


def engines_of(names: str | None) -> tuple[str, ...]:
    """The engines of a list of names with commas, or `all` that are installed."""
    return readers() if names == "all" else tuple(filter(None, (names or "").split(",")))


def new_file(target: Path) -> Path:
    """A path where a file can be written and none is; raises ParameterError."""
    if target.suffix != ".xml" or target.exists() or target.is_symlink():
        raise ParameterError("write trimmed", str(target), "an .xml file that does not exist yet")
    if not target.parent.is_dir():
        raise ParameterError("write trimmed", str(target), "in a folder that exists")
    return target


def start_given(chosen: argparse.Namespace) -> dict[str, Any]:
    """The start that the options name; raises ParameterError."""
    lists = {
        name: [values.number(name, part) for part in text.split(",")]
        for name in ("qpos", "qvel")
        if (text := getattr(chosen, name)) is not None
    }
    return {"keyframe": chosen.keyframe, **lists}


def trimmed_file(audit: Audit, source: Path, target: Path, start: Start = AS_IT_STANDS) -> Audit:
    """Write the model `source` without what `audit` leaves out, and run it as it is read back;
    raises ParameterError where nothing is, or it cannot be written."""
    together = audit.trims.together if audit.trims else None
    models = find_engine("mujoco").ability(UserModels)
    assert models is not None
    if together is None or audit.found is None or audit.model is None:
        raise ParameterError("write trimmed", str(target), "left away: nothing can be left out")
    left_out = models.write_trimmed(source, together.changes, target)
    offered = [(left_out, models.model(target, start))]
    steps = audit.found
    (read_back,) = tried(audit.model, audit.script, steps.own.parts, steps.index, offered)
    return replace(audit, written=(target.name, read_back))


def policy_of(name: str) -> Policy:
    """The function MODULE:FUNCTION, also of a module in the present folder; raises
    ParameterError."""
    module, colon, function = name.partition(":")
    sys.path.insert(0, os.getcwd())
    try:
        found = getattr(importlib.import_module(module), function) if colon else None
    except Exception as error:
        reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
        raise ParameterError("policy", name, f"MODULE:FUNCTION ({reason})") from None
    finally:
        sys.path.remove(os.getcwd())
    if not callable(found):
        raise ParameterError("policy", name, "MODULE:FUNCTION, a function of time, qpos and qvel")
    return cast(Policy, found)


def controls_of(file: Path) -> Array:
    """Controls from a .csv file, a row for each period, or the array `ctrl` of a .npz file; raises
    ParameterError."""
    what = f"{', '.join(KINDS)}, or a .csv or .npz file of controls"
    if file.suffix not in (".csv", ".npz") or not file.is_file():
        raise ParameterError("ctrl", str(file), what)
    if file.stat().st_size > _LARGEST:
        raise ParameterError("ctrl", str(file), f"a file of {_LARGEST} bytes at most")
    try:
        if file.suffix == ".npz":
            with np.load(file, allow_pickle=False) as arrays:
                return np.asarray(arrays["ctrl"]).astype(float, casting="same_kind")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of no rows, which its shape tells
            return np.loadtxt(file, delimiter=",", ndmin=2)
    except (ValueError, TypeError, KeyError, OSError, EOFError, BadZipFile) as error:
        reason = " ".join(str(error).split())
        raise ParameterError("ctrl", str(file), f"{what} ({reason})") from None
