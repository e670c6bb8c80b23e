"""The table of gymnasium's files, audited at rest and under sines, each confirmed in a third way.

    python -m plumbob.tests.audit.gymnasium_table [FILE ...]

Prints a row a file and control; exits 1 where fewer than wanted are certified and confirmed.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from plumbob.engines.audit.audit import Audit
from plumbob.reports.view.audit.text import duration, length
from plumbob.tests.audit.robot_files import file_audit, folder
from plumbob.tests.audit.test_robot_files import (
    BUDGET,
    CASES,
    NAMES,
    UNMOVED,
    WANTED,
    certified,
    confirmed,
)

HEAD = (
    "file", "control", "own step", "certified to", "U", "error there", "order",
    "cheapest for 1 mm", "processor time", "third way",
)  # fmt: skip


def row(found: Audit, control: str, third: str) -> list[str]:
    """An audit as cells; error and uncertainty where the error is last resolved."""
    last, steps = found.resolved_index, found.found
    cells = [found.name, control, f"{found.integrator} {duration(found.step)}"]
    if steps is None or not found.error:
        what = "nothing moves" if steps else found.reference.why
        return [*cells, "–", "–", "–", "–", "–", f"{found.seconds:.0f} s", what]
    best = next((c for c in steps.cheapest if c.target == 1e-3), None)
    order = steps.order
    return [
        *cells,
        f"{found.script.times[last]:.3g} s",
        f"{found.reference.uncertainty[last]:.1e} m",
        length(steps.own.at(last)),
        f"{order.slope:.2g} [{order.low:.2g}, {order.high:.2g}]" if order else "–",
        f"{best.integrator} {duration(best.step)} (×{best.cost:.2g})" if best else "none found",
        f"{found.seconds:.0f} s",
        third,
    ]


def main(names: Sequence[str]) -> int:
    """Print the table of these files, or all; returns an exit code."""
    files = folder("gymnasium")
    if files is None:
        print("gymnasium is not installed: pip install 'plumbob[robots]'", file=sys.stderr)
        return 2
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}")
    counted = 0
    for name, control in [case for case in CASES if not names or case[0] in names]:
        found = file_audit(files / f"{name}.xml", control, BUDGET)
        third = "–"
        if (name, control) not in UNMOVED:
            good = certified(found) and confirmed(found)
            counted += good
            why = found.reference.why or "the error is not resolved"
            third = "agrees" if good else "differs" if certified(found) else why
        print(f"| {' | '.join(row(found, control, third))} |", flush=True)
    print(f"{counted} certified and confirmed")
    return int(not names and counted < WANTED)


if __name__ == "__main__":
    if unknown := set(sys.argv[1:]) - set(NAMES):
        sys.exit(f"no such file: {', '.join(sorted(unknown))}")
    sys.exit(main(sys.argv[1:]))
