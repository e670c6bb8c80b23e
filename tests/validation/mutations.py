"""Change a line of a copy of the tree, one at a time, and see whether a test turns red.

    python -m plumbob.tests.validation.mutations [NAME]

Prints every mutation with `killed` or `SURVIVED`; exits 1 when one survived.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from plumbob.tests.contracts.tree import PACKAGE, files

ROOT = Path(__file__).parents[2]
OUTCOME, COMPARE = "tests/commands/test_validate_outcome.py", "tests/commands/test_compare.py"
SABOTAGE = "tests/commands/test_sabotage.py"
TABLES, STUDY = "tests/reports/test_tables.py", "tests/study/test_study.py"


@dataclass(frozen=True)
class Mutation:
    """A line of a file, what it becomes, and the tests that are to notice."""

    name: str
    file: str
    line: str
    becomes: str
    tests: str


VALIDATE, JUNIT = "reports/commands/validate.py", "reports/commands/junit.py"
JUDGE, TERMINAL = "reports/judge/expectations.py", "reports/view/terminal.py"
MUTATIONS = (
    Mutation("exit 1 becomes 0", VALIDATE, "        return 1\n", "        return 0\n", OUTCOME),
    Mutation("exit 3 becomes 0", VALIDATE, "INCOMPLETE = 3", "INCOMPLETE = 0", OUTCOME),
    Mutation("exit 3 of run becomes 0", "reports/commands/run.py", "INCOMPLETE = 3",
             "INCOMPLETE = 0", OUTCOME),
    Mutation("exit 1 of run becomes 0", "reports/commands/run.py",
             "return 1 if run_surprise", "return 0 if run_surprise", OUTCOME),
    Mutation("exit 1 of growth becomes 0", "reports/commands/compare.py",
             "return 1 if grown else 0", "return 0", COMPARE),
    Mutation("no failure in the JUnit file", JUNIT, 'if means == "unexpected":', "if False:",
             OUTCOME),
    Mutation("no failure counted in it", JUNIT, 'str(counts["failure"])', '"0"', OUTCOME),
    Mutation("known limits pass in it", JUNIT, 'if means == "known limit":', "if False:", OUTCOME),
    Mutation("unexpected is never printed", TERMINAL, '!= "unexpected":', '!= "":', OUTCOME),
    Mutation("another step than the reference", "engines/study/measurement.py",
             "return min(done, key=lambda m: abs(", "return max(done, key=lambda m: abs(", OUTCOME),
    Mutation("0 unexpected, always", TERMINAL, "means['unexpected']", "0", OUTCOME),
    Mutation("the page shows the coarsest run", "reports/view/tables.py",
             "for m in reversed(c.measurements)", "for m in c.measurements", TABLES),
    Mutation("observed order as predicted", "reports/view/tables.py",
             "_order(c.predicted_order if", "_order(c.order if", TABLES),
    Mutation("cost at the coarsest step", "engines/study/runner.py",
             "else len(done) // 2]", "else 0]", STUDY),
    Mutation("a study stops at the first floor", "engines/study/convergence.py",
             "        if at_floor > 2:", "        if at_floor > 0:", STUDY),
    Mutation("unsupported is always accepted", JUDGE,
             "if refused(scene.name, method.name, found) else", "if False else", OUTCOME),
    Mutation("pre-asymptotic is always accepted", JUDGE,
             'scene.profile == "full" and bool(allowed)', "True", OUTCOME),
    Mutation("fail is always accepted of a known limit", JUDGE,
             'if found.cut and "not-converging" in allowed:', 'if "not-converging" in allowed:',
             OUTCOME),
    Mutation("known limits have any size", JUDGE,
             "why = known.differs(found.errors)", 'why = ""', OUTCOME),
    Mutation("one run of a known limit has any size", JUDGE,
             "why = next((known.differs_at(*entry) for entry in found.errors.items()), \"\")",
             'why = ""', OUTCOME),
    Mutation("any accuracy is good enough", JUDGE, "[finest := min(found.errors)] <= within",
             "[finest := min(found.errors)] >= 0.0", OUTCOME),
    Mutation("observables may be left out", "reports/judge/verdict.py",
             'if found.status != "done" or not names:', "if True:", SABOTAGE),
    Mutation("what vanished is not said", "reports/commands/compare.py",
             "if pair not in after:", "if False:", COMPARE),
    Mutation("small changes are not listed", "reports/commands/compare.py",
             "MOVED = 1e-9", "MOVED = 1e-3", COMPARE),
)  # fmt: skip


def killed(mutation: Mutation, tree: Path) -> bool:
    """Whether a test of the copy `tree` fails with this mutation in it, which is then undone."""
    path = tree / mutation.file
    text = path.read_text("utf-8")
    if text.count(mutation.line) < 1:
        raise LookupError(f"{mutation.name}: {mutation.file} has no {mutation.line!r}")
    path.write_text(text.replace(mutation.line, mutation.becomes, 1), "utf-8")
    done = subprocess.run(
        [sys.executable, "-B", "-m", "pytest", "-x", "-p", "no:cacheprovider", mutation.tests],
        cwd=tree, env={**os.environ, "PYTHONPATH": str(tree.parent)}, check=False,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    path.write_text(text, "utf-8")
    if done.returncode not in (0, 1):
        raise RuntimeError(f"{mutation.name}: pytest ended with {done.returncode}")
    return done.returncode == 1


def main(names: list[str]) -> int:
    """Try the mutations of these names, or all; returns an exit code."""
    chosen = [m for m in MUTATIONS if not names or m.name in names]
    survived = 0
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / PACKAGE
        for path in files(ROOT):
            (tree / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / path, tree / path)
        for mutation in chosen:
            found = killed(mutation, tree)
            survived += not found
            print(f"{'killed' if found else 'SURVIVED'}: {mutation.name}", flush=True)
    print(f"{len(chosen)} mutations, {survived} survived")
    return int(survived > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
