"""plumbob plan: the capsule brought to a pose: its manoeuvres, their time, where they lead."""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any

from analytic.parameters import ParameterError, known
from analytic.planner import Limits, Plan, RestPose
from analytic.planner import plan as find_plan
from engines.measurement import Measurement, measure
from engines.registry import method as find_method
from models.registry import scene as find_scene
from models.registry import system_of, systems
from models.tripod_capsule.parameters import BODY, CHECK, capsule
from reports.commands import values

LIMITS = tuple(field.name for field in fields(Limits))
PLACES = ("start", "slider", "slider_at_end")
SYSTEM = "capsule-plan"
MISSING = 3


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    # Without this argparse takes -1e-3 for an option.
    parser._negative_number_matcher = re.compile(r"^-(\d|\.\d)")
    parser.add_argument(
        "--to", nargs=3, required=True, metavar=("X", "Y", "PSI"),
        help="where to: place of the body's centre of mass [m], heading [rad]",
    )  # fmt: skip
    parser.add_argument("--track", default="free", metavar="free|curve", help="where the slider is")
    values.add_changes(parser)
    parser.add_argument("--method", metavar="METHOD", help="also run the plan open-loop")
    parser.add_argument("--step", metavar="DT", help="with --method: step [s]")
    parser.add_argument("--json", action="store_true", help="print JSON, with every digit")


def command(chosen: argparse.Namespace) -> int:
    """Print the manoeuvres, the total time and where the reference ends, and an engine's errors."""
    changes = values.changes(chosen.changes)
    known(changes, (*BODY, *LIMITS, *PLACES))
    if (chosen.method is None) != (chosen.step is None):
        raise ParameterError("step", chosen.step, "given with --method, and only with it")
    found = planned(chosen.to, chosen.track, changes)
    answer = described(found)
    measured = _measured(chosen, found, changes) if chosen.method else None
    if measured is not None:
        answer["method"] = {
            "name": chosen.method,
            "step": measured.step,
            "status": measured.status,
            "reason": measured.reason,
            "errors_at_end": {name: error.end for name, error in measured.errors.items()},
        }
    if chosen.json:
        json.dump(values.plain(answer), sys.stdout, indent=1)
        print()
    else:
        _print(answer)
    return MISSING if measured is not None and measured.status == "missing" else 0


def planned(to: list[str], track: Any, changes: Mapping[str, Any]) -> Plan:
    """The plan that the arguments ask for; raises ParameterError."""
    body = capsule({**CHECK, **{name: changes[name] for name in BODY if name in changes}})
    limits = Limits(**{name: changes[name] for name in LIMITS if name in changes})
    x, y, heading = (values.number(*pair) for pair in zip(("x", "y", "psi"), to, strict=True))
    slider = changes.get("slider", (0.0, 0.0))
    begun = changes.get("start", (0.0, 0.0, 0.0))
    if not isinstance(begun, (list, tuple)) or len(begun) != 3:
        raise ParameterError("start", begun, "a pose [x, y, psi]")
    start = RestPose(begun[0], begun[1], begun[2], slider)
    goal = RestPose(x, y, heading, changes.get("slider_at_end", slider))
    return find_plan(body, goal, limits, track, start)


def described(found: Plan) -> dict[str, Any]:
    """What there is to say of a plan, as plain data."""
    distance, angle = found.error
    return {
        "start": asdict(found.start),
        "goal": asdict(found.goal),
        "track": found.track,
        "limits": asdict(found.limits),
        "parameters": asdict(found.capsule),
        "total_time": found.duration,
        "turns": found.turns,
        "lines": found.lines,
        "manoeuvres": [
            {
                "kind": one.kind,
                "start": one.start,
                "duration": one.duration,
                "parameters": dict(one.parameters),
            }
            for one in found.manoeuvres
        ],
        "reached": asdict(found.reached),
        "position_error": distance,
        "heading_error": angle,
    }


def _measured(chosen: argparse.Namespace, found: Plan, changes: Mapping[str, Any]) -> Measurement:
    method, step = find_method(chosen.method), values.positive_number("step", chosen.step)
    if SYSTEM not in systems():
        reason = f"no engine can run a plan yet: there is no system {SYSTEM}"
        return Measurement(SYSTEM, method.name, step, "missing", reason)
    goal = (found.goal.x, found.goal.y, found.goal.heading)
    scene = find_scene(SYSTEM, {**changes, "to": goal, "track": found.track})
    return measure(system_of(scene), scene, method, step)[0]


def _print(answer: Mapping[str, Any]) -> None:
    goal, track = answer["goal"], answer["track"]
    print(
        f"to ({goal['x']:g}, {goal['y']:g}) m and {goal['heading']:g} rad, slider on the "
        f"{'free plane' if track == 'free' else 'curve'}: {answer['turns']} turns and "
        f"{answer['lines']} lines in {answer['total_time']:.6g} s"
    )
    print(f"{'start [s]':>12} {'lasts [s]':>12}  manoeuvre")
    for one in answer["manoeuvres"]:
        given = ", ".join(f"{name} {value:.6g}" for name, value in one["parameters"].items())
        print(f"{one['start']:>12.6f} {one['duration']:>12.6f}  {one['kind']:<5} {given}".rstrip())
    print(
        f"the reference ends {answer['position_error']:.2g} m and "
        f"{answer['heading_error']:.2g} rad from the goal"
    )
    if "method" in answer:
        run = answer["method"]
        print(f"{run['name']} at {run['step']:g} s: {run['status']} {run['reason']}".rstrip())
        for name, error in run["errors_at_end"].items():
            print(f"  {name}: ends {error:.4g} off")
