"""plumbob run: one run of a scene with a method and a step: its errors and its cost."""

from __future__ import annotations

import argparse
import json
import sys

from engines.cost import costs
from engines.measurement import measure
from engines.registry import method as find_method
from models.registry import scene as find_scene
from models.registry import system_of
from reports.commands import values
from reports.expectations import expected
from reports.records import record
from reports.verdict import judge


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("scene", metavar="SCENE", help="system/case, or a system's default case")
    parser.add_argument("method", metavar="METHOD", help="engine/name: see `plumbob list methods`")
    parser.add_argument("--step", required=True, metavar="DT", help="step [s], or rtol (adaptive)")
    values.add_changes(parser)
    parser.add_argument("--json", action="store_true", help="print JSON")


def command(chosen: argparse.Namespace) -> int:
    """Print errors against the exact answer, their tolerances and the cost."""
    method = find_method(chosen.method)
    scene = find_scene(chosen.scene, values.changes(chosen.changes))
    step = values.positive_number("step", chosen.step)
    system = system_of(scene)
    found, _ = measure(system, scene, method, step)
    timed = [(system, scene, method, step)] if found.status == "done" else []
    measured, unit = costs(timed, repeats=5)
    cost = measured.get((scene.name, method.name))
    one = record(scene, method, found, None, cost)
    if chosen.json:
        json.dump(values.plain(one), sys.stdout, indent=1)
        print()
    else:
        print(
            f"{scene.name} with {method.name} at {step:g}: {one['verdict']}"
            + (f" ({one['reason']})" if one["reason"] else "")
        )
        for name, bound in judge(found, system, method).tolerances.items():
            print(
                f"  {name}: error {found.errors[name].largest:.4g} {bound.unit}, "
                f"allowed {bound.bound:.4g}"
            )
            for term in bound.terms:
                print(f"    {term.value:10.3g}  {term.name}: {term.reason}")
        for name, drift in found.invariants.items():
            print(f"  {name}: relative drift {drift:.4g}")
        if cost:
            print(
                f"  cost: {cost.ns_per_step:.0f} ns a step, {cost.ratio:.2f} of the yardstick's "
                f"{unit:.0f} ns; {one['real_time_factor']:.0f} times real time"
            )
        for warning in found.warnings:
            print(f"  {method.engine} says: {warning}")
    if found.status == "missing":
        return 3
    good = ("coarse", expected(scene.name, method.name).verdict)
    return 0 if one["verdict"] in good else 1
