"""Search around every quick scene, with every method, for where an error is least as predicted.

    python -m plumbob.tests.validation.worst_cases [--scenes GLOB] [--methods GLOB] [--budget RUNS]

Pairs whose limits are known are left out. Every parameter with one number is varied between 0.8 and
1.25 of its value, headings and directions all around. Prints what each search found, those that use
most of their tolerance last; exits 1 where one uses more than all of it.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator, Sequence

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import Method
from plumbob.engines.registry import engine_of, installed, methods
from plumbob.engines.study.measurement import REFERENCE_STEP
from plumbob.engines.study.runner import pairs
from plumbob.engines.sweep.box import Side, box
from plumbob.engines.sweep.worst import Found, search
from plumbob.models.registry import scenes
from plumbob.models.scene import Scene
from plumbob.reports.commands.worst import of_tolerance
from plumbob.reports.judge.expectations import expected
from plumbob.reports.view.sweep.text import command

AROUND = ("heading", "direction", "psi")
FACTORS = (0.8, 1.25)
LIMITED, BELOW = ("fraction",), (0.8, 1.0)  # of the friction limit, above which nothing holds


def sides(scene: Scene) -> Iterator[Side]:
    """What is varied of a scene."""
    for name, value in scene.parameters.items():
        if name in AROUND:
            yield Side(name, 0.0, 2.0 * math.pi)
        elif isinstance(value, float) and value:
            factors = BELOW if name in LIMITED else FACTORS
            low, high = sorted(f * value for f in factors)
            yield Side(name, low, high)


def searched(scene: Scene, method: Method, budget: int) -> Found | None:
    """What a search around a scene finds; None where nothing has an error."""
    fitting = min(scene.steps, key=lambda h: abs(math.log(h / REFERENCE_STEP)))
    step = method.step_sizes[-1] if method.control == "tolerance" else fitting
    try:
        return search(box(scene.name, {}, list(sides(scene))), method, step, budget, of_tolerance)
    except ParameterError:
        return None


def main(words: Sequence[str]) -> int:
    """Search, and print; returns an exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", default="*")
    parser.add_argument("--methods", default="*")
    parser.add_argument("--budget", type=int, default=200)
    chosen = parser.parse_args(words)
    ran = [m for m in methods(chosen.methods) if installed(engine_of(m))]
    found = []
    for scene, method in pairs(scenes(chosen.scenes, "quick"), ran):
        if expected(scene.name, method.name).verdict != "predicted":
            continue
        one = searched(scene, method, chosen.budget)
        if one is None:
            print(f"nothing  {scene.name} {method.name}", flush=True)
            continue
        found.append(one)
        print(_line(one), flush=True)
    print()
    for one in sorted(found, key=lambda one: one.score)[-10:]:
        print(_line(one))
    return int(any(one.score > 1.0 for one in found))


def _line(found: Found) -> str:
    parameters = {**dict(found.box.changes), **found.parameters}
    repeated = command(found.box.scene, found.method, found.step, parameters)
    return f"{found.score:8.3g}  error {found.error:.2g}  {repeated}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
