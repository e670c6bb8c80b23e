"""The largest steps that an audit says of files, and nudged runs on both sides of each.

    python -m plumbob.tests.audit.robots.largest_steps [--ctrl rest|zero|sines] [FILE ...]

Prints a row for each file of dm_control's suite and of gymnasium, and each integrator: the limit
that the step's Jacobians predict along the certified motion, what the audit says, and what nudged
runs at 0.9 and 1.1 of it do. Limits beyond ten times the file's step are said as that, and held
against a run there. Exits 1 where fewer than nine in ten predictions are confirmed.
"""

from __future__ import annotations

import argparse
import sys
import time

from plumbob.engines.audit.controls import script
from plumbob.engines.audit.reference import certified
from plumbob.engines.audit.stability import ABOVE, BELOW, BEYOND, Course, limited
from plumbob.engines.audit.step_errors import known
from plumbob.engines.own_motion import NotCertifiable
from plumbob.reports.view.notation import duration
from plumbob.tests.audit.robots.certificates import files
from plumbob.tests.audit.robots.robot_files import file_model

BUDGET = 10.0  # [s] of processor time for the reference
WANTED = 0.9  # of the predictions are to be confirmed
CONFIRMED, BEYOND_TRIED, MEASURED = "confirmed", "beyond: confirmed", "by runs alone"
HEAD = (
    "package",
    "file",
    "own step",
    "integrator",
    "predicted",
    "said",
    "first to go",
    "at 0.9",
    "at 1.1",
    "verdict",
)


def course_of(model, control):
    """A model along its certified motion."""
    moved = script(model, control)
    reference = certified(model, moved, BUDGET, time.process_time)
    return Course(model, moved, reference.course.states[: known(reference) + 1])


def verdict(course, limit):
    """What nudged runs do at both sides of a limit, and what follows."""
    most = BEYOND * course.model.step
    step = limit.largest_step or most

    def run(side):
        lost = course.lost(limit.integrator, side * step, limit.index)
        return "lost" if lost else "holds"

    if not limit.confirmed:
        return "–", "–", f"NOT CONFIRMED: {limit.why}"
    if limit.largest_step is None:
        at_most = run(1.0)
        return at_most, "–", BEYOND_TRIED if at_most == "holds" else "NOT CONFIRMED"
    below, above = run(BELOW), run(ABOVE)
    if limit.predicted != step:
        return below, above, MEASURED
    return below, above, CONFIRMED if (below, above) == ("holds", "lost") else "NOT CONFIRMED"


def rows(course):
    """The limits of all integrators as cells."""
    for name in course.model.steppable:
        limit = limited(course, name)
        sides = verdict(course, limit)
        most = f"> {duration(BEYOND * course.model.step)}"
        predicted = most if limit.predicted is None else duration(limit.predicted)
        said = most if limit.largest_step is None else duration(limit.largest_step)
        why = f"{sides[-1]}: {limit.why}" if limit.why and limit.largest_step else sides[-1]
        own = f"{course.model.integrator} {duration(course.model.step)}"
        yield [own, name, predicted, said, limit.first, *sides[:-1], why]


def main(arguments):
    """Print the table of some files, or all; returns an exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ctrl", default="rest")
    parser.add_argument("names", nargs="*")
    chosen = parser.parse_args(arguments)
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}", flush=True)
    counts = dict.fromkeys((CONFIRMED, BEYOND_TRIED, MEASURED, "NOT CONFIRMED"), 0)
    for package, path in files():
        if chosen.names and path.stem not in chosen.names:
            continue
        try:
            course = course_of(file_model(path), chosen.ctrl)
        except NotCertifiable as reason:
            print(f"| {package} | {path.stem} |{' – |' * 7} refused: {reason} |", flush=True)
            continue
        for cells in rows(course):
            print(f"| {package} | {path.stem} | {' | '.join(cells)} |", flush=True)
            counts[next(v for v in counts if cells[-1].startswith(v))] += 1
    print(", ".join(f"{count} {what}" for what, count in counts.items()))
    return int(counts[CONFIRMED] + counts[BEYOND_TRIED] < WANTED * sum(counts.values()))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
