"""Measure how large the errors of known limits are, and the errors of solvers at their tolerances,
and write them into the engines' tables of sizes in `engines/limits`.

The first line of a table holds the versions. Each other line is a scene with a method: the median
of the relative errors over the finest runs of the quick profile, from step `coarse` to `fine` [s],
and the smallest and largest error of the runs from `coarsest` to `fine`; for a solver that chooses
its steps the relative error by tolerance, above the round-off level.

    python -m plumbob.tests.validation.limit_sizes [--profile full] [--scenes GLOB] [--methods GLOB]
        [--missing]

Runs each pair of a scene and a method that a limit is declared for, at the steps of the quick
profile, and each with a solver that chooses its steps; what is in the files and was not chosen
stays there, and pairs without a declared limit leave them. `--missing` measures only what they do
not hold. Look at the differences before they are committed: a size that changes says that an
engine, or plumbob, has.
"""

import argparse
import json
import math
import sys
from dataclasses import asdict

from plumbob.analytic.schemes import ADAPTIVE
from plumbob.engines.known_limits import FOLDER, SIZES_SUFFIX, Size, declared_by
from plumbob.engines.registry import find_engine, methods
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import convergence_study
from plumbob.engines.study.measurement import relative_error, rounding_bound, worst
from plumbob.engines.study.provenance import NOT_INSTALLED, packages_of, provenance
from plumbob.engines.study.runner import most_steps, pairs
from plumbob.models.registry import case_of, matching_scenes, system_of
from plumbob.reports.judge.expectations import expected
from plumbob.reports.judge.known_sizes import measured_size

# round-offs: below, what a processor rounds otherwise may be as large as the error
ABOVE = 100.0


def of_study(scene, found):
    """The size of a convergence study's errors; None where no run was made to its end."""
    case = case_of(scene)
    about = case.system.quantities(case)
    listed = [
        m for m in found.measurements if m.step not in found.beside
    ]  # as a verdict has it
    errors = {m.step: relative_error(m, about) for m in listed or found.measurements}
    finite = {step: error for step, error in errors.items() if math.isfinite(error)}
    return measured_size(finite) if finite else None


def of_solver(scene, found):
    """The relative errors of a solver's study, by tolerance, above ABOVE round-offs; None where no
    run was made to its end."""
    about = system_of(scene).quantities(case_of(scene))
    errors = {}
    for m in (m for m in found.measurements if m.status == "done"):
        quantity, error = worst(m, about)
        level = rounding_bound(m.errors[quantity.observable], m.steps) / quantity.scale
        errors |= {m.step: error} if error > ABOVE * level else {}
    return errors or None


def of_pair(pair):
    """The size of a known limit, or the errors of a solver, with the names of its scene and
    method."""
    scene, method = pair
    found = convergence_study(scene, method, most_steps(scene, "quick"))
    of = of_solver if method.control == "tolerance" else of_study
    return scene.name, method.name, of(scene, found)


def limits(of_scenes, of_methods, profile):
    """The pairs that a limit is declared for, and those of solvers that choose their steps."""
    every = pairs(matching_scenes(of_scenes, profile), methods(of_methods))
    return [(s, m) for s, m in every if sized(s.name, m.name)]


def sized(scene, method):
    """Whether a file holds a size of the pair."""
    solver = find_method(method).scheme.integrator == ADAPTIVE
    return solver or expected(scene, method).limit


def text(sizes, versions):
    """The table of these sizes, by {(scene, method): Size, or errors by tolerance}."""
    lines = [json.dumps({"measured_with": versions})]
    for (scene, method), size in sorted(sizes.items(), key=_by_kind):
        lines.append(json.dumps({"scene": scene, "method": method, **_values(size)}))
    return "".join(f"{line}\n" for line in lines)


def _by_kind(entry):
    """A key that sorts entries of `text` by kind, then by scene and method."""
    pair, size = entry
    return not isinstance(size, Size), pair


def _values(size):
    """The numbers of a size as a table holds them, to six digits."""
    if isinstance(size, Size):
        return {name: _rounded(value) for name, value in asdict(size).items()}
    return {"solver": {f"{tolerance:g}": _rounded(error) for tolerance, error in size.items()}}


def _rounded(value):
    return float(f"{value:.6g}")


def held_of(name):
    """The sizes that the table of an engine holds."""
    limits = declared_by(find_engine(name))
    return {**limits.sizes, **limits.solvers}


def write(name, sizes, folder=FOLDER):
    """Write the table of an engine with the sizes of the pairs that still have one, as measured
    with the versions that are installed."""
    engine = find_engine(name)
    now = provenance("").versions
    here = {package: now.get(package, NOT_INSTALLED) for package in packages_of(engine)}
    here = {package: version for package, version in here.items() if version != NOT_INSTALLED}
    versions = {**declared_by(engine).measured_with, **here}
    kept = {pair: size for pair, size in sizes.items() if sized(*pair)}
    table = folder / f"{name}{SIZES_SUFFIX}"
    table.write_text(text(kept, versions), "utf-8")


def main(arguments):
    """Measure and write; returns an exit code."""
    parser = argparse.ArgumentParser(description="Writes the sizes of known limits.")
    parser.add_argument("--profile", choices=("quick", "full"), default="quick")
    parser.add_argument("--scenes", default="*")
    parser.add_argument("--methods", default="*")
    parser.add_argument("--missing", action="store_true")
    chosen = parser.parse_args(arguments)
    asked = limits(chosen.scenes, chosen.methods, chosen.profile)
    held = {name: held_of(name) for name in sorted({m.engine for _, m in asked})}
    if chosen.missing:
        asked = [(s, m) for s, m in asked if (s.name, m.name) not in held[m.engine]]
    for scene, method, size in map(of_pair, asked):
        if size is not None:
            name = find_method(method).engine
            held[name][scene, method] = size
            write(name, held[name])  # what is measured stays, however the rest ends
        print(scene, method, size or "no run", flush=True)
    for name, sizes in held.items():
        write(name, sizes)
    print(f"{len(asked)} measured, into files in {FOLDER}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
