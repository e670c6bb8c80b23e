"""Measure how large the errors of known limits are, and those of solvers at their tolerances, and
write reports/judge/known_limits.toml.

    python -m plumbob.tests.validation.limit_sizes [--profile full] [--scenes GLOB] [--methods GLOB]
        [--missing]

Runs each pair of a scene and a method that a limit is declared for, at the steps of the quick
profile, and each with a solver that chooses its steps; what is in the file and was not chosen stays
there, and pairs without a declared limit leave it. `--missing` measures only what the file does not
hold. Look at the differences before they are committed: a size that changes says that an engine, or
plumbob, has.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from plumbob.analytic.errors.schemes import ADAPTIVE
from plumbob.engines.method import Method
from plumbob.engines.registry import method as find_method
from plumbob.engines.registry import methods
from plumbob.engines.study.convergence import ConvergenceStudy, convergence_study
from plumbob.engines.study.measurement import relative_error, rounding, worst
from plumbob.engines.study.provenance import ABSENT, provenance
from plumbob.engines.study.runner import most_steps, pairs
from plumbob.models.registry import case_of, scenes, system_of
from plumbob.models.scene import Scene
from plumbob.reports.judge.expectations import expected
from plumbob.reports.judge.known_limits import (
    FILE,
    Size,
    errors_of_solvers,
    measured,
    sizes,
    stored,
)

Errors = Mapping[float, float]
Sizes = Mapping[tuple[str, str], Size | Errors]
ABOVE = 100.0  # round-offs: below, what a processor rounds otherwise may be as large as the error
HEAD = """\
# Relative errors of known limits, by scene and method: the median over the finest runs of the quick
# profile, from step `coarse` to `fine` [s], and what its runs from `coarsest` to `fine` span; and
# those of solvers that choose their steps, by tolerance, above the round-off level.
# Written by `python -m plumbob.tests.validation.limit_sizes`; measured with these
# versions, for which they are known within 2 %, and for others within a factor of two.

[measured_with]
"""


def of_study(scene: Scene, found: ConvergenceStudy) -> Size | None:
    """The size of a convergence study's errors; None where no run was made to its end."""
    case = case_of(scene)
    about = case.system.quantities(case)
    errors = {m.step: relative_error(m, about) for m in found.measurements}
    finite = {step: error for step, error in errors.items() if math.isfinite(error)}
    return measured(finite) if finite else None


def of_solver(scene: Scene, found: ConvergenceStudy) -> Errors | None:
    """The relative errors of a solver's study, by tolerance, above ABOVE round-offs; None where no
    run was made to its end."""
    about = system_of(scene).quantities(case_of(scene))
    errors: dict[float, float] = {}
    for m in (m for m in found.measurements if m.status == "done"):
        quantity, error = worst(m, about)
        level = rounding(m.errors[quantity.observable], m.steps) / quantity.scale
        errors |= {m.step: error} if error > ABOVE * level else {}
    return errors or None


def of_pair(pair: tuple[Scene, Method]) -> tuple[str, str, Size | Errors | None]:
    """The size of a known limit, or the errors of a solver, with the names of its scene and
    method."""
    scene, method = pair
    found = convergence_study(scene, method, most_steps(scene, "quick"))
    of = of_solver if method.control == "tolerance" else of_study
    return scene.name, method.name, of(scene, found)


def limits(of_scenes: str, of_methods: str, profile: str) -> list[tuple[Scene, Method]]:
    """The pairs that a limit is declared for, and those of solvers that choose their steps."""
    every = pairs(scenes(of_scenes, profile), methods(of_methods))
    return [(s, m) for s, m in every if sized(s.name, m.name)]


def sized(scene: str, method: str) -> bool:
    """Whether the file holds a size of the pair."""
    solver = find_method(method).scheme.integrator == ADAPTIVE
    return solver or expected(scene, method).limit


def text(found: Sizes) -> str:
    """The file that holds these sizes."""
    now = {k: v for k, v in provenance("").versions.items() if v != ABSENT and k != "plumbob"}
    lines = [HEAD, *(f'"{k}" = "{v}"\n' for k, v in (stored()["measured_with"] | now).items())]
    table = ""
    for (scene, method), size in sorted(found.items(), key=lambda entry: (_kind(entry[1]), entry)):
        if table != (table := f'\n[{_kind(size)}."{scene}"]\n'):
            lines.append(table)
        values = asdict(size) if isinstance(size, Size) else size
        held = ", ".join(f"{_key(name)} = {v:.6g}" for name, v in values.items())
        lines.append(f'"{method}" = {{ {held} }}\n')
    return "".join(lines)


def _kind(size: Size | Errors) -> str:
    return "limits" if isinstance(size, Size) else "solvers"


def _key(name: str | float) -> str:
    return name if isinstance(name, str) else f'"{name:g}"'


def write(found: Sizes, file: Path = FILE) -> None:
    """Write the sizes of the pairs that have one still."""
    kept = {pair: size for pair, size in found.items() if sized(*pair)}
    file.write_text(text(kept), "utf-8")


def main(arguments: list[str]) -> int:
    """Measure and write; returns an exit code."""
    parser = argparse.ArgumentParser(description="Writes the sizes of known limits.")
    parser.add_argument("--profile", choices=("quick", "full"), default="quick")
    parser.add_argument("--scenes", default="*")
    parser.add_argument("--methods", default="*")
    parser.add_argument("--missing", action="store_true")
    chosen = parser.parse_args(arguments)
    held: dict[tuple[str, str], Size | Errors] = {**sizes(), **errors_of_solvers()}
    asked = limits(chosen.scenes, chosen.methods, chosen.profile)
    if chosen.missing:
        asked = [(s, m) for s, m in asked if (s.name, m.name) not in held]
    for scene, method, size in map(of_pair, asked):
        if size is not None:
            held[scene, method] = size
            write(held)  # what is measured stays, however the rest ends
        print(scene, method, size or "no run", flush=True)
    write(held)
    print(f"{len(asked)} measured, {len(held)} in {FILE}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
