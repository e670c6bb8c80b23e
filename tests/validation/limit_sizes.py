"""Measure how large the errors of known limits are, and write reports/judge/known_limits.toml.

    python -m plumbob.tests.validation.limit_sizes [--profile full] [--scenes GLOB] [--methods GLOB]
        [--missing] [--jobs N]

Runs each pair of a scene and a method that a limit is declared for, at the steps of the quick
profile; what is in the file and was not chosen stays there, and pairs without a declared limit
leave it. `--missing` measures only what the file does not hold. Look at the differences before
they are committed: a size that changes says that an engine, or plumbob, has.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import sys
from collections.abc import Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from pathlib import Path

from plumbob.engines.method import Method
from plumbob.engines.registry import methods
from plumbob.engines.study.convergence import ConvergenceStudy, convergence_study
from plumbob.engines.study.measurement import relative_error
from plumbob.engines.study.provenance import provenance
from plumbob.engines.study.runner import most_steps, pairs
from plumbob.models.registry import case_of, scenes
from plumbob.models.scene import Scene
from plumbob.reports.judge.expectations import expected
from plumbob.reports.judge.known_limits import FILE, Size, measured, sizes

Sizes = Mapping[tuple[str, str], Size]
HEAD = """\
# Relative errors of known limits, by scene and method: the median over the finest runs of the quick
# profile, from step `coarse` to `fine` [s], and what its runs from `coarsest` to `fine` span.
# Written by `python -m plumbob.tests.validation.limit_sizes`; measured with
# {versions}.
"""


def of_study(scene: Scene, found: ConvergenceStudy) -> Size | None:
    """The size of a convergence study's errors; None where no run was made to its end."""
    case = case_of(scene)
    about = case.system.quantities(case)
    errors = {m.step: relative_error(m, about) for m in found.measurements}
    finite = {step: error for step, error in errors.items() if math.isfinite(error)}
    return measured(finite) if finite else None


def of_pair(pair: tuple[Scene, Method]) -> tuple[str, str, Size | None]:
    """The size of a known limit, with the names of its scene and method."""
    scene, method = pair
    found = convergence_study(scene, method, most_steps(scene, "quick"))
    return scene.name, method.name, of_study(scene, found)


def limits(of_scenes: str, of_methods: str, profile: str) -> list[tuple[Scene, Method]]:
    """The pairs that a limit is declared for."""
    every = pairs(scenes(of_scenes, profile), methods(of_methods))
    return [(s, m) for s, m in every if expected(s.name, m.name).limit]


def text(found: Sizes) -> str:
    """The file that holds these sizes."""
    versions = ", ".join(f"{k} {v}" for k, v in provenance("").versions.items())
    lines = [HEAD.format(versions=versions)]
    for scene in sorted({scene for scene, _ in found}):
        lines.append(f'\n[limits."{scene}"]\n')
        for (of, method), size in sorted(found.items()):
            if of == scene:
                values = ", ".join(f"{name} = {v:.6g}" for name, v in _floats(size))
                lines.append(f'"{method}" = {{ {values} }}\n')
    return "".join(lines)


def _floats(size: Size) -> Iterable[tuple[str, float]]:
    return asdict(size).items()


def write(found: Sizes, file: Path = FILE) -> None:
    """Write the sizes of the pairs that a limit is declared for still."""
    kept = {pair: size for pair, size in found.items() if expected(*pair).limit}
    file.write_text(text(kept), "utf-8")


def main(arguments: list[str]) -> int:
    """Measure and write; returns an exit code."""
    parser = argparse.ArgumentParser(description="Writes the sizes of known limits.")
    parser.add_argument("--profile", choices=("quick", "full"), default="quick")
    parser.add_argument("--scenes", default="*")
    parser.add_argument("--methods", default="*")
    parser.add_argument("--missing", action="store_true")
    parser.add_argument("--jobs", type=int, default=1)
    chosen = parser.parse_args(arguments)
    held = dict(sizes()) if FILE.exists() else {}
    asked = limits(chosen.scenes, chosen.methods, chosen.profile)
    if chosen.missing:
        asked = [(s, m) for s, m in asked if (s.name, m.name) not in held]
    with ProcessPoolExecutor(chosen.jobs, multiprocessing.get_context("spawn")) as pool:
        for done in as_completed([pool.submit(of_pair, pair) for pair in asked]):
            scene, method, size = done.result()
            if size is not None:
                held[scene, method] = size
                write(held)  # what is measured stays, however the rest ends
            print(scene, method, "no run" if size is None else f"{size.size:.3g}", flush=True)
    write(held)
    print(f"{len(asked)} measured, {len(held)} in {FILE}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
