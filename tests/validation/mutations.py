"""Change a line of a copy of the tree, one at a time, and see whether a test turns red.

    python -m plumbob.tests.validation.mutations [LAYER | NAME ...]

The mutations are in mutants/LAYER.toml, each with its file, the line, what that becomes, and the
tests that are to notice. Prints every mutation with `killed` or `SURVIVED`; exits 1 when one
survived that is not a known survivor.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path

from plumbob.tests.contracts.tree import PACKAGE, files

ROOT = Path(__file__).parents[2]
MUTANTS = Path(__file__).parent / "mutants"
LONGEST = 3600.0  # [s] of tests: a change that makes them run on for ever is noticed


@dataclass(frozen=True)
class Mutation:
    """A line of a file, what it becomes, and the tests that are to notice."""

    layer: str
    name: str
    file: str
    line: str
    becomes: str
    tests: str  # files and folders, separated by spaces
    survives: str = ""  # why no test notices, where none does


def mutations():
    """All mutations, layer by layer."""
    return tuple(
        Mutation(path.stem, name, **fields)
        for path in sorted(MUTANTS.glob("*.toml"))
        for name, fields in tomllib.loads(path.read_text("utf-8")).items()
    )


def killed(mutation, tree):
    """Whether a test of the copy `tree` fails with this mutation in it, which is then undone;
    raises LookupError where the line is not in its file exactly once."""
    path = tree / mutation.file
    text = path.read_text("utf-8")
    if text.count(mutation.line) != 1:
        raise LookupError(f"{mutation.name}: {mutation.file} has not one {mutation.line!r}")
    path.write_text(text.replace(mutation.line, mutation.becomes), "utf-8")
    try:
        return not passes(mutation.tests.split(), tree)
    finally:
        path.write_text(text, "utf-8")


def passes(tests, tree):
    """Whether these tests of the copy `tree` pass, all of their cases; raises RuntimeError where
    pytest does not run them."""
    options = ("-x", "-p", "no:cacheprovider", "--suite", "all")
    try:
        done = subprocess.run(
            [sys.executable, "-B", "-m", "pytest", *options, *tests],
            cwd=tree,
            env={**os.environ, "PYTHONPATH": str(tree.parent)},
            check=False,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=LONGEST,
        )
    except subprocess.TimeoutExpired:
        return False
    if 1 < done.returncode < 6:  # below 0 it was ended by a signal: an engine's own assertion
        raise RuntimeError(f"pytest ended with {done.returncode}: {done.stdout[-2000:]}")
    return done.returncode == 0


def copied(folder):
    """A copy of the tree in `folder`."""
    tree = folder / PACKAGE
    for path in files(ROOT):
        (tree / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / path, tree / path)
    return tree


def main(names):
    """Try the mutations of these layers or names, or all; returns an exit code."""
    chosen = [m for m in mutations() if not names or {m.name, m.layer} & set(names)]
    if unknown := set(names) - {m.name for m in mutations()} - {m.layer for m in mutations()}:
        print(f"no mutation and no layer: {', '.join(sorted(unknown))}", file=sys.stderr)
        return 2
    survived = 0
    with tempfile.TemporaryDirectory() as folder:
        tree = copied(Path(folder))
        if not passes(sorted({t for m in chosen for t in m.tests.split()}), tree):
            print("the tests fail without any mutation")
            return 1
        for mutation in chosen:
            found = killed(mutation, tree)
            survived += not found and not mutation.survives
            word = "killed" if found else "survived, known" if mutation.survives else "SURVIVED"
            print(f"{word}: {mutation.name}", flush=True)
    known = sum(bool(m.survives) for m in chosen)
    print(f"{len(chosen)} mutations, {known} known to survive, {survived} others survived")
    return int(survived > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
