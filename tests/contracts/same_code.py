"""Compare the code of two revisions: python -m plumbob.tests.contracts.same_code BEFORE [AFTER].

The code of a file is its syntax tree without comments and without strings that stand as statements:
docstrings of modules, classes and functions, and strings under attributes. A commit that changes
words alone leaves the code of every Python file as it was. AFTER is the working tree if it is left
out. Prints the files whose code differs, and other files that differ; exits with 1 if the code of a
file does.
"""

import ast
import subprocess
import sys
from pathlib import Path


class _WithoutStrings(ast.NodeTransformer):
    """Removes strings that stand as statements."""

    def visit_Expr(self, node):
        """None for a string, else the statement."""
        is_string = isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        return None if is_string else node


def code_of(text):
    """The syntax tree of a file as text, without comments and strings that stand as statements."""
    return ast.dump(_WithoutStrings().visit(ast.parse(text)))


def _git(*arguments):
    """The output of a git command; raises subprocess.CalledProcessError."""
    done = subprocess.run(["git", *arguments], capture_output=True, text=True, check=True)
    return done.stdout


def _text_at(revision, path):
    """The text of a file in a revision, in the working tree if that is empty; None if absent."""
    if not revision:
        return Path(path).read_text() if Path(path).exists() else None
    done = subprocess.run(["git", "show", f"{revision}:{path}"], capture_output=True, text=True)
    return done.stdout if done.returncode == 0 else None


def differences(before, after=""):
    """Two lists of paths: Python files whose code differs between two revisions, and other files
    that differ. A file that one revision lacks is in the first list."""
    revisions = [before, after] if after else [before]
    changed = _git("diff", "--name-only", "--no-renames", *revisions).splitlines()
    other = [path for path in changed if not path.endswith(".py")]
    code = []
    for path in changed:
        if path.endswith(".py"):
            texts = [_text_at(revision, path) for revision in (before, after)]
            if None in texts or code_of(texts[0]) != code_of(texts[1]):
                code.append(path)
    return code, other


def main(arguments):
    """The exit code: 1 if the code of a file differs."""
    code, other = differences(*arguments)
    for path in code:
        print(f"code differs: {path}")
    for path in other:
        print(f"text differs: {path}")
    if not code:
        print("no code differs")
    return int(bool(code))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
