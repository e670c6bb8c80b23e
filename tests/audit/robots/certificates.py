"""Certificates held against a file's own integrators at steps 256 to 4096 times smaller.

    python -m plumbob.tests.audit.robots.certificates [--budget SECONDS] [FILE ...]

Prints a row for each file of dm_control's suite and of gymnasium, at rest and under sines: what the
audit claims of the file's step, what steps that small confirm, and whether the certificate has them
outside; exits 1 where it has.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.reference import RESOLVED, largest
from plumbob.engines.own_motion import NotCertifiable
from plumbob.reports.view.notation import duration, metres
from plumbob.tests.audit.robots.robot_files import file_audit, folder

BUDGET = 60.0  # [s] of processor time for an audit
FINEST, LEAST = 4096, 256  # times smaller than the own step
MANY = 1e3  # roundings of a motion that up to a million steps may add up to, in a random walk
LIMIT = 60.0  # [s] of processor time that a run is to take
# From a step to a quarter of it an error that goes as a power from a half on is at least halved:
# what is left of it is at most what the two differ by.
QUARTER = 4
PACKAGES = ("dm_control", "gymnasium")
HEAD = (
    "package",
    "file",
    "control",
    "own step",
    "certified to",
    "claimed",
    "confirmed",
    "by steps",
    "apart, of the certificate",
    "verdict",
)
HOLDS, OUTSIDE, OPEN = "holds", "OUTSIDE", "not outside: steps tell less"


@dataclass(frozen=True)
class Confirmation:
    """What small steps of one integrator make of a motion that is certified, at the ends of the
    control periods."""

    integrator: str
    finer: int  # times smaller than the own step
    apart: Array  # [m] from the reference at most so far
    scatter: Array  # [m] how far these steps may be from their own limit
    error: float  # [m] of the own step, held against them


def confirmations(found, limit=LIMIT):
    """Euler and RK4 at steps as small as `limit` [s] of processor time each allow."""
    model, script, steps = found.model, found.script, found.found
    count = steps.index + 1

    def motion(integrator, factor):
        run = model.stepped(script, integrator, factor * steps.own.parts)
        return model.positions(run.states[:count]), run.seconds

    own, _ = motion(found.integrator, 1)
    confirmed = []
    for integrator in ("euler", "rk4"):
        seconds = motion(integrator, QUARTER**2)[1] / QUARTER**2
        most = limit / (seconds * (1 + 1 / QUARTER))
        factor = next((f for f in (FINEST, FINEST // QUARTER) if f <= most), LEAST)
        fine, coarse = (motion(integrator, f)[0] for f in (factor, factor // QUARTER))
        apart = so_far(fine, found.reference.positions[:count])
        error = float(so_far(own, fine)[-1])
        confirmed.append(Confirmation(integrator, factor, apart, so_far(fine, coarse), error))
    return sorted(confirmed, key=lambda c: c.scatter[-1])


def verdict(found, confirmed):
    """Whether the certificate has the small steps of both integrators outside, or the better ones
    tell less than it does."""
    best, rounding = confirmed[0], MANY * found.reference.rounding
    known = found.reference.uncertainty[: best.apart.size]
    if np.all([c.apart > known + c.scatter + rounding for c in confirmed], axis=0).any():
        return OUTSIDE
    tells = best.scatter[-1] <= max(RESOLVED * known[-1], rounding)
    return HOLDS if tells else OPEN


def so_far(one, other):
    """The largest distance [m] of any body so far between two motions, shape (n,)."""
    return largest(np.linalg.norm(one - other, axis=2))


def row(found, limit):
    """An audit and its confirmation as cells."""
    cells = [f"{found.integrator} {duration(found.step)}"]
    if found.found is None:
        return [*cells, *("–",) * 5, f"none: {found.reference.why}"]
    confirmed = confirmations(found, limit)
    best, known, why = confirmed[0], found.uncertainty, found.reference.why
    return [
        *cells,
        f"{found.until:.3g} s",
        f"{metres(found.error)} ± {metres(known)}",
        f"{metres(best.error)} ± {metres(float(best.scatter[-1]))}",
        f"{best.integrator} /{best.finer}",
        f"{best.apart[-1] / known:.2g}" if known else "–",
        verdict(found, confirmed) + (f"; then: {why}" if why else ""),
    ]


def files():
    """Model files of these packages, where they are installed."""
    folders = [(package, folder(package)) for package in PACKAGES]
    return [(package, path) for package, at in folders if at for path in sorted(at.glob("*.xml"))]


def main(arguments):
    """Print the table of some files, or all; returns an exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--budget", type=float, default=BUDGET)
    parser.add_argument("--limit", type=float, default=LIMIT)
    parser.add_argument("names", nargs="*")
    chosen = parser.parse_args(arguments)
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}", flush=True)
    outside = 0
    for package, path in files():
        if chosen.names and path.stem not in chosen.names:
            continue
        for control in ("rest", "sines"):
            try:
                cells = row(file_audit(path, control, chosen.budget), chosen.limit)
            except NotCertifiable as reason:
                cells = [*("–",) * 6, f"refused: {reason}"]
            outside += OUTSIDE in cells[-1]
            print(f"| {package} | {path.stem} | {control} | {' | '.join(cells)} |", flush=True)
    print(f"{outside} outside")
    return int(bool(outside))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
