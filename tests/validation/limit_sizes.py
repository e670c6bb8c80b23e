"""Measure how large the errors of known limits are, and those of solvers at their tolerances, and
write them into the engines' files in `engines/limits`, below what is declared there by hand.

    python -m plumbob.tests.validation.limit_sizes [--profile full] [--scenes GLOB] [--methods GLOB]
        [--missing]

Runs each pair of a scene and a method that a limit is declared for, at the steps of the quick
profile, and each with a solver that chooses its steps; what is in the files and was not chosen
stays there, and pairs without a declared limit leave them. `--missing` measures only what they do
not hold. Look at the differences before they are committed: a size that changes says that an
engine, or plumbob, has.
"""

import argparse
import math
import sys
from dataclasses import asdict

from plumbob.analytic.schemes import ADAPTIVE
from plumbob.engines.known_limits import FOLDER, Size, declared_by
from plumbob.engines.registry import find_engine, methods
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import convergence_study
from plumbob.engines.study.measurement import relative_error, rounding, worst
from plumbob.engines.study.provenance import ABSENT, packages_of, provenance
from plumbob.engines.study.runner import most_steps, pairs
from plumbob.models.registry import case_of, scenes, system_of
from plumbob.reports.judge.expectations import expected
from plumbob.reports.judge.known_sizes import measured_size

# round-offs: below, what a processor rounds otherwise may be as large as the error
ABOVE = 100.0
HEAD = """\
# Below: written by `python -m plumbob.tests.validation.limit_sizes`. Relative errors of known
# limits, by scene and method: the median over the finest runs of the quick profile, from step
# `coarse` to `fine` [s], and what its runs from `coarsest` to `fine` span; and those of solvers
# that choose their steps, by tolerance, above the round-off level. They are known within 2 % for
# these versions, and for others within a factor of two.

[measured_with]
"""


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
        level = rounding(m.errors[quantity.observable], m.steps) / quantity.scale
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
    every = pairs(scenes(of_scenes, profile), methods(of_methods))
    return [(s, m) for s, m in every if sized(s.name, m.name)]


def sized(scene, method):
    """Whether a file holds a size of the pair."""
    solver = find_method(method).scheme.integrator == ADAPTIVE
    return solver or expected(scene, method).limit


def text(sizes, versions):
    """The part of an engine's file that holds these sizes."""
    lines = [HEAD, *(f'"{package}" = "{version}"\n' for package, version in versions.items())]
    table = ""
    for (scene, method), size in sorted(
        sizes.items(), key=lambda entry: (_kind(entry[1]), entry)
    ):
        if table != (table := f'\n[{_kind(size)}."{scene}"]\n'):
            lines.append(table)
        values = asdict(size) if isinstance(size, Size) else size
        held = ", ".join(f"{_key(name)} = {v:.6g}" for name, v in values.items())
        lines.append(f'"{method}" = {{ {held} }}\n')
    return "".join(lines)


def _kind(size):
    return "sizes" if isinstance(size, Size) else "solvers"


def _key(name):
    return name if isinstance(name, str) else f'"{name:g}"'


def held_of(name):
    """The sizes that the file of an engine holds."""
    limits = declared_by(find_engine(name))
    return {**limits.sizes, **limits.solvers}


def write(name, sizes, folder=FOLDER):
    """Write into the file of an engine the sizes of the pairs that have one still, as measured with
    the versions that are installed."""
    file = folder / f"{name}.toml"
    declared = file.read_text("utf-8").partition(HEAD)[0] if file.is_file() else ""
    engine = find_engine(name)
    now = provenance("").versions
    here = {package: now.get(package, ABSENT) for package in packages_of(engine)}
    here = {package: version for package, version in here.items() if version != ABSENT}
    versions = {**declared_by(engine).measured_with, **here}
    kept = {pair: size for pair, size in sizes.items() if sized(*pair)}
    file.write_text(f"{declared.rstrip()}\n\n{text(kept, versions)}".lstrip(), "utf-8")


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
