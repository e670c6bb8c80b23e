"""Draw steps that nobody listed by many seeds, and tell what is unexpected of the runs at them.

    python -m plumbob.tests.validation.drawn_steps FIRST LAST [SCENES [METHODS]]

Takes each pair of the quick profile that the patterns choose. Prints each unexpected run, and last
the largest errors over those at listed steps, which the factors of `expectations._drawn` are
calibrated against; exits with 1 where a run was unexpected.
"""

import math
import sys
from dataclasses import dataclass, replace

from plumbob.engines.registry import engine_of, installed, methods
from plumbob.engines.study.convergence import convergence_study, drawn_step
from plumbob.engines.study.measurement import measure
from plumbob.engines.study.runner import most_steps, pairs
from plumbob.models.registry import case_of, scenes, system_of
from plumbob.reports.judge.expectations import held_to, surprise
from plumbob.reports.judge.verdict import judged


@dataclass(frozen=True)
class Drawn:
    """A run at a drawn step: why it is unexpected, if it is, and its error over those at listed
    steps that it is held to, NaN where it is held to its prediction."""

    name: str
    control: str
    unexpected: str
    ratio: float


def drawn(scene, method, seeds):
    """The runs of a pair at the steps that these seeds draw."""
    case, about = case_of(scene), system_of(scene).quantities(case_of(scene))
    found = convergence_study(scene, method, most_steps(scene, "quick"))
    for seed in seeds:
        if (step := drawn_step(found.measurements, scene, method, seed)) is None:
            return
        more = replace(found, drawn=measure(case, method, step)[0])
        whole = judged(more, case.system, method, about).whole
        held = held_to(scene, method, whole, step)
        error = whole.drawn.errors.get(step, math.nan)
        ratio = error / max(held) if held else math.nan
        name = f"{scene.name} {method.name} {step:.6g} (seed {seed})"
        yield Drawn(name, method.control, surprise(scene, method, whole), ratio)


def main(arguments):
    """Draw and print; returns an exit code."""
    first, last, of_scenes, of_methods = [*arguments, "*", "*"][:4]
    chosen = pairs(scenes(of_scenes, "quick"), methods(of_methods))
    runs = []
    for scene, method in chosen:
        if installed(engine_of(method)):
            runs += drawn(scene, method, range(int(first), int(last) + 1))
    wrong = [run for run in runs if run.unexpected]
    print(*(f"{run.name}: {run.unexpected}" for run in wrong), sep="\n")
    for control in ("step", "tolerance"):
        most = max(
            (r for r in runs if r.control == control and r.ratio >= 0.0),
            key=lambda run: run.ratio,
            default=None,
        )
        print(f"largest by {control}: {most}")
    print(f"{len(runs)} runs, {len(wrong)} unexpected")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
