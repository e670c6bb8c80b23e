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
from collections.abc import Callable, Mapping, Sequence
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
from plumbob.engines.audit.contacts import HEADINGS, SPEED, ContactAudit, Measured
from plumbob.engines.audit.controls import KINDS
from plumbob.engines.audit.costs import Ratio
from plumbob.engines.audit.gradient import Gradients
from plumbob.engines.audit.stability import Limit
from plumbob.engines.audit.trims import Trim, tried
from plumbob.engines.own_motion import AS_IT_STANDS, Policy, Start
from plumbob.engines.registry import find_engine
from plumbob.reports.commands import several_audits
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.several_audits import Row, model_files
from plumbob.reports.judge.audit_from_python import BUDGET, audit, audit_contacts, start_of
from plumbob.reports.view.audit.page import answered, lines, rows, write_page
from plumbob.reports.view.audit.page import page as page_text
from plumbob.reports.view.content import Finding

MISSED, REFUSED = 1, 2  # the accuracy or stability asked for; the input
PATIENCE = 10.0  # times the budget, after which an audit of several hangs
_LARGEST = 100_000_000  # bytes of a control file


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "model",
        metavar="FILE.xml",
        nargs="+",
        help="a MuJoCo model; or several, folders and patterns: a table, the largest error first",
    )
    _motion_arguments(parser)
    parser.add_argument("--duration", metavar="T", help="[s] of the motion; default: 1")
    parser.add_argument("--absolute", metavar="METRES", help="exit 1 unless the error is within")
    parser.add_argument(
        "--stable",
        action="store_const",
        const=True,
        help="exit 1 if the file's own step is unstable along the motion",
    )
    parser.add_argument(
        "--gradient",
        action="store_const",
        const=True,
        help="derivatives of the end by controls and start, too; up to as much time again",
    )
    parser.add_argument(
        "--budget", metavar="SECONDS", help=f"wall time, about; default: {BUDGET:g}"
    )
    parser.add_argument(
        "--jobs", metavar="N", help="processes that try integrators, or models; default: 1"
    )
    parser.add_argument(
        "--write-trimmed",
        metavar="FILE.xml",
        help="write the model without what this motion does not need, to this new file",
    )
    parser.add_argument(
        "--contacts",
        action="store_true",
        help="the contact audit: the free body slides, turns and is pushed on its plane, joints "
        "locked, with the file's friction settings and those of `plumbob settings`",
    )
    parser.add_argument("--body", metavar="NAME", help="--contacts: which body; the heaviest")
    parser.add_argument(
        "--speed", metavar="V", help=f"--contacts: [m/s] at which it slides; default: {SPEED:g}"
    )
    parser.add_argument(
        "--friction", metavar="F", help="--contacts: the coefficient, in place of the file's"
    )
    parser.add_argument("--out", metavar="DIR", help="write the page audit-NAME.html there")
    parser.add_argument("--json", action="store_true", help="print JSON, with every digit")


def _motion_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--keyframe", metavar="K", help="start from this keyframe, name or number")
    for name, unit in (("qpos", "m, rad"), ("qvel", "m/s, rad/s")):
        what = f"[{unit}] start with these in place of the model's: as many as it has"
        parser.add_argument(f"--{name}", metavar="X,X,...", help=what)

    parser.add_argument(
        "--ctrl",
        metavar="|".join((*KINDS, "FILE")),
        default="rest",
        help="the control: what the model starts with, nothing, a sine for each actuator (of 0.3 of"
        " half its range, at 0.7 Hz, the next at 0.13 Hz more, and so on), or a .csv or .npz file"
        " with a row for each period; default: rest",
    )
    parser.add_argument(
        "--policy",
        metavar="MODULE:FUNCTION",
        help="a control of your own: called with time, qpos and qvel at each period, by default a"
        " step; what it gives at the model's own step is replayed",
    )
    parser.add_argument("--ctrl-period", metavar="T", help="[s] a control is held; about 0.02")


def command(chosen: argparse.Namespace) -> int:
    """Print the audit; returns 1 where an accuracy, or stability, that is asked for is missed."""
    numbers = {
        name: values.positive_number(name.replace("_", " "), text)
        for name in ("ctrl_period", "duration", "absolute", "budget", "speed", "friction")
        if (text := getattr(chosen, name)) is not None
    }
    target = None if chosen.write_trimmed is None else new_file(Path(chosen.write_trimmed))
    if chosen.out is not None and Path(chosen.out).exists() and not Path(chosen.out).is_dir():
        raise ParameterError("out", chosen.out, "a folder to write into")
    _fits(chosen)
    if chosen.policy is not None and chosen.ctrl != "rest":
        raise ParameterError("ctrl", chosen.ctrl, "left out with --policy")
    jobs = 1 if chosen.jobs is None else values.count("jobs", chosen.jobs)
    if (files := model_files(chosen.model)) is not None:
        if target is not None:
            raise ParameterError("write trimmed", str(target), "left out with several models")
        return _several(files, chosen, numbers, jobs)
    from plumbob.reports.commands.validate import progress

    (file,) = map(Path, chosen.model)
    with progress() as show:
        answer = _of_file(file, chosen, numbers, jobs, lambda what: show(what, 0, 0))
    if target is not None and isinstance(answer, Audit):
        answer = trimmed_file(answer, file, target, start_of(**start_given(chosen)))
    return _answered(answer, chosen, numbers.get("absolute"))


def _of_file(
    file: Path,
    chosen: argparse.Namespace,
    numbers: Mapping[str, float],
    jobs: int = 1,
    progress: Callable[[str], None] = lambda what: None,
) -> Audit | ContactAudit:
    """The audit of one file; raises ParameterError."""
    if chosen.contacts:
        return audit_contacts(
            file,
            speed=numbers.get("speed", SPEED),
            body=chosen.body,
            friction=numbers.get("friction"),
            keyframe=chosen.keyframe,
        )
    return audit(
        file,
        chosen.ctrl if chosen.ctrl in KINDS else controls_of(Path(chosen.ctrl)),
        **start_given(chosen),
        duration=numbers.get("duration"),
        period=numbers.get("ctrl_period"),
        budget=numbers.get("budget", BUDGET),
        jobs=jobs,
        progress=progress,
        gradient=bool(chosen.gradient),
        policy=None if chosen.policy is None else policy_of(chosen.policy),
    )


def _row(file: Path, chosen: argparse.Namespace, numbers: Mapping[str, float]) -> Row:
    """The audit of one file of several, its page written where one is wanted."""
    path = str(file)
    try:
        found = _of_file(file, chosen, numbers)
    except ParameterError as why:
        refused = {"model": path, "path": path, "error": None, "why": str(why)}
        return Row(path, None, None, str(why), REFUSED, refused)
    answer = answered(found)
    if isinstance(found, ContactAudit):
        error, data = found.error(found.own[0]), contact_data(found)
    else:
        error, data = found.error, as_data(found)
    known = None if error is None or math.isnan(error) else error
    said = dict(rows(answer)).get("to do", "")
    whole = "" if chosen.out is None else _page_text(answer, found, chosen, path)
    code = _asked(found, numbers.get("absolute"), bool(chosen.stable))
    return Row(path, known, found.step, said, code, {**data, "path": path}, whole)


def _several(
    files: Sequence[Path], chosen: argparse.Namespace, numbers: Mapping[str, float], jobs: int
) -> int:
    """Print a table of several audits, or their JSON; the exit code is the largest of any."""
    from plumbob.reports.commands.validate import progress

    began, found = time.monotonic(), list[Row]()
    limit = PATIENCE * numbers.get("budget", BUDGET)
    do = partial(_row, chosen=chosen, numbers=numbers)
    with progress() as show:
        try:
            for row in several_audits.audited(files, do, jobs, limit):
                found.append(_with_page(row, chosen))
                show(f"{row.path} audited", len(found), len(files))
        except KeyboardInterrupt:  # what is done is not lost
            print("\n".join(several_audits.lines(several_audits.sorted_rows(found))))
            raise
    found = several_audits.sorted_rows(found)
    if chosen.out is not None:
        command = _command(chosen, " ".join(map(shlex.quote, chosen.model)))
        seconds = time.monotonic() - began
        print(several_audits.write_page(found, Path(chosen.out), command, seconds), file=sys.stderr)
    if chosen.json:
        json.dump(values.plain([row.data for row in found]), sys.stdout, indent=1)
        print()
    else:
        print("\n".join(several_audits.lines(found)))
    return max(row.code for row in found)


def _answered(audit: Audit | ContactAudit, chosen: argparse.Namespace, metres: float | None) -> int:
    """Print an audit as text or JSON, and write its page where one is wanted; returns the exit
    code."""
    answer = answered(audit)
    if chosen.out is not None:
        print(page(answer, audit, chosen), file=sys.stderr)
    if chosen.json:
        data = contact_data(audit) if isinstance(audit, ContactAudit) else as_data(audit)
        json.dump(values.plain(data), sys.stdout, indent=1)
        print()
    else:
        print("\n".join(lines(answer)))
    return _asked(audit, metres, bool(chosen.stable))


def _asked(audit: Audit | ContactAudit, metres: float | None, stable: bool) -> int:
    """The exit code: whether an accuracy or stability that was asked for is missed."""
    try:
        if stable and isinstance(audit, Audit):
            audit.assert_stable()
        if metres is not None:
            audit.assert_within(metres)
    except AssertionError as why:
        print(f"plumbob: {why}", file=sys.stderr)
        return MISSED
    return 0


def _fits(chosen: argparse.Namespace) -> None:
    """Raises ParameterError for an option of one audit that is given to the other."""
    motion = (
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
        "gradient",
    )
    for name in motion if chosen.contacts else ("body", "speed", "friction"):
        if (value := getattr(chosen, name)) not in (None, "rest"):
            what = "left out with --contacts" if chosen.contacts else "given with --contacts"
            raise ParameterError(name.replace("_", " "), value, what)


def _with_page(row: Row, chosen: argparse.Namespace) -> Row:
    """The row with the name of its page in place of the page, once that is written: here, since
    processes would give two pages one name. Raises ParameterError."""
    return replace(row, page=_written(row.page, row.path, chosen).name) if row.page else row


def page(answer: Finding, audit: Audit | ContactAudit, chosen: argparse.Namespace) -> Path:
    """Write the page of an answer into a folder; raises ParameterError where it cannot be
    written."""
    text = _page_text(answer, audit, chosen, chosen.model[0])
    return _written(text, audit.name, chosen)


def _written(text: str, model: str, chosen: argparse.Namespace) -> Path:
    folder = Path(chosen.out)
    try:
        return write_page(text, model, folder, chosen.contacts)
    except OSError as error:
        raise ParameterError("out", str(folder), f"a folder to write into ({error})") from None


def _page_text(
    answer: Finding, audit: Audit | ContactAudit, chosen: argparse.Namespace, file: str
) -> str:
    """The page, with the command that reproduces it and a picture of the model."""
    drawn = audit.model.picture() if audit.model else None
    return page_text(answer, audit, _command(chosen, shlex.quote(file)), drawn)


def _command(chosen: argparse.Namespace, files: str) -> str:
    """The command that repeats an audit of `files`."""
    options = (
        "keyframe",
        "qpos",
        "qvel",
        "ctrl",
        "policy",
        "ctrl_period",
        "duration",
        "budget",
        "jobs",
        "body",
        "speed",
        "friction",
    )
    options_given = [(o, v) for o in options if (v := getattr(chosen, o)) not in (None, "rest")]
    words = [w for o, v in options_given for w in (f"--{o.replace('_', '-')}", str(v))]
    words += ["--contacts"] * chosen.contacts + ["--gradient"] * bool(chosen.gradient)
    return f"plumbob audit {files} {shlex.join([*words, '--out', chosen.out])}"


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


def as_data(audit: Audit) -> dict[str, Any]:
    """An audit as plain data."""
    steps = audit.found

    def trim(ablation: Trim) -> dict[str, Any]:
        done = {"left_out": ablation.name, "same_bits": ablation.same_bits, "moved": ablation.moved}
        return {**done, "accepted": ablation.accepted(audit.error), **spread(ablation.cost)}

    return {
        "model": audit.name,
        "integrator": audit.integrator,
        "step": audit.step,
        "control": audit.control,
        "control_period": audit.script.period,
        "duration": audit.script.duration,
        "certified_until": audit.until,
        "uncertainty": audit.uncertainty,
        "error": audit.error,
        "resolved_until": float(audit.script.times[audit.resolved_index]),
        "resolved": audit.resolved if steps else False,
        "why": audit.reference.why,
        "not_smooth": audit.reference.not_smooth,
        "layer_widths": audit.reference.widths,
        "events": audit.reference.course.events,
        "clamped": audit.clamped,
        "notes": (*audit.notes, *(steps.own.remarks if steps else ())),
        "to_do": dict(rows(answered(audit)))["to do"],
        "worst_body": steps.own.worst if steps else None,
        "order": None if not steps or not steps.order else steps.order.__dict__,
        "steps": []
        if steps is None
        else [
            {
                "integrator": s.integrator,
                "step": s.step,
                "error": s.at(steps.index),
                "ns_per_second": s.ns_per_second,
                "why": s.why,
                "cost": s.cost and s.cost.__dict__,
            }
            for s in steps.steps
        ],
        "cheapest": []
        if steps is None
        else [{**c.__dict__, **spread(c.cost)} for c in steps.cheapest],
        "likely": None if audit.likely is None else audit.likely.__dict__,
        "balances": [b.__dict__ for b in audit.balances],
        "trims": []
        if audit.trims is None
        else [trim(t) for t in (*audit.trims.each, *filter(None, [audit.trims.together]))],
        "trimmed_file": None if audit.written is None else trim(audit.written[1]),
        "slides": audit.slides or None,
        **stability_data(audit),
        **gradient_data(audit.gradient),
        "seconds": audit.seconds,
    }


def stability_data(audit: Audit) -> dict[str, Any]:
    """The largest steps that hold [s], and what raises the own integrator's, as plain data."""

    def limit(largest: Limit) -> dict[str, Any]:
        names = ("integrator", "largest_step", "first", "confirmed", "why", "predicted", "chatters")
        return {name: getattr(largest, name) for name in names}

    known = audit.stability
    return {
        "stability": [limit(largest) for largest in known.limits] if known else [],
        "unstable": known.unstable if known else None,
        "remedies": [{"change": r.name, **limit(r.limit), "moved": r.moved} for r in known.remedies]
        if known
        else [],
    }


def gradient_data(known: Gradients | str | None) -> dict[str, Any]:
    """Derivatives of the end, their horizon [s] and best eps, as plain data; nothing where they are
    not asked for."""
    if known is None:
        return {}
    if isinstance(known, str):
        return {"gradient": [], "gradient_horizon": None, "gradient_why": known}
    measured = next(way.eps for way in known.ways if way.name == "central")
    return {
        "gradient": [entry.__dict__ for entry in known.entries],
        "gradient_horizon": known.horizon,
        "gradient_why": known.why,
        "gradient_ways": {way.name: way.why for way in known.ways},
        "gradient_left_out": known.left_out,
        "best_eps": {"predicted": known.predicted_eps, "measured": measured},
    }


def spread(cost: Ratio | None) -> dict[str, Any]:
    """A cost in multiples of the model's own, and what its quartiles leave open, as plain data."""
    if cost is None:
        return {"cost": None, "spread": None}
    return {"cost": cost.value, "spread": [cost.low, cost.high]}


def contact_data(audit: ContactAudit) -> dict[str, Any]:
    """A contact audit as plain data."""
    body = audit.standing

    def run(measured: Measured, predicted: Any = None) -> dict[str, Any]:
        return {
            "step": measured.step,
            "distances": measured.distances,
            "errors": audit.errors(measured),
            "predicted_errors": predicted,
            "direction_dependence": audit.dependence(measured),
            "turned": measured.turned,
            "drift": measured.drift,
            "turn": measured.turning.turn if measured.turning and measured.turning.rests else None,
        }

    return {
        "model": audit.name,
        "integrator": audit.integrator,
        "step": audit.step,
        "body": {**body.__dict__, "points": body.points},
        "speed": audit.speed,
        "spin": audit.spin,
        "headings": HEADINGS,
        "distance": audit.exact,
        "not_determined": audit.why,
        "compared_with": audit.distances,
        "known_to": audit.known,
        "turn": audit.exact_turn,
        "turn_not_determined": audit.why_turn,
        "turn_compared_with": audit.turn,
        "turn_known_to": audit.turn_known,
        "own": [run(measured) for measured in audit.own],
        "pasted": [run(measured, audit.predicted(measured)) for measured in audit.pasted],
        "not_run": audit.failed,
        "method": audit.method,
        "stiffness": audit.stiffness,
        "to_paste": audit.snippet,
        "notes": audit.notes,
        "seconds": audit.seconds,
    }
