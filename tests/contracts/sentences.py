"""Contracts on how code reads: docstrings and comments are no fragments, a statement holds one
idea, and a public name stands for one thing."""

import ast
import io
import re
import tokenize
from pathlib import Path

from plumbob.tests.contracts.tree import LAYERS, python

FIRST_WORDS = re.compile(r"(Of|That|Those|The same|Where|What|Why)\b")
FRAGMENTS = re.compile(r"#\s*(of|that|which|whose)\b")
# Names that a registry or a table looks up in every module of a kind, and those of the API for
# packages that add engines, systems or findings.
LOOKED_UP = {
    *(
        "ENGINE",
        "METHODS",
        "MODEL",
        "SCENES",
        "SECTION",
        "SYSTEM",
        "SYSTEMS",
        "KINDS",
        "SCHEMES",
    ),
    *("build", "claims", "command", "facts", "fill", "ideal", "interest", "invariants", "main"),
    *("model_error", "numbers", "observe", "prepare", "problem", "requests", "scheme"),
    *("Case", "KnownLimit", "Method"),
    *("PI", "double", "quad"),  # numbers of quadruple precision, by either of two packages
}
TWICE = Path(__file__).with_name("names_twice.txt")


def _in_layers(root):
    """The files of the layers with their syntax trees."""
    return ((path, module) for path, module in python(root) if path.parts[0] in LAYERS)


def fragmentary_docstrings(root):
    """Docstrings that begin with a word that leaves their subject out."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    return [
        f"{path}: {getattr(node, 'name', 'module')}: {text.splitlines()[0]}"
        for path, module in _in_layers(root)
        for node in ast.walk(module)
        if isinstance(node, documented)
        and FIRST_WORDS.match(text := ast.get_docstring(node) or "")
    ]


def fragmentary_comments(root):
    """Comments whose first line begins in the middle of a sentence."""
    found = []
    for path, _ in _in_layers(root):
        text = (root / path).read_text("utf-8")
        lines = text.splitlines()
        last = -1
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            if token.type != tokenize.COMMENT:
                continue
            line = token.start[0]
            goes_on = line == last + 1 and lines[line - 1].lstrip().startswith("#")
            if not goes_on and FRAGMENTS.match(token.string):
                found.append(f"{path}:{line}: {token.string}")
            last = line
    return found


COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)


def crowded_statements(root):
    """Assignments within a call or a comprehension, conditional expressions within another, and
    comprehensions with more than two loops."""
    found = []
    for path, module in _in_layers(root):
        for node in ast.walk(module):
            inner = [part for child in ast.iter_child_nodes(node) for part in ast.walk(child)]
            if isinstance(node, (*COMPREHENSIONS, ast.Call)) and any(
                isinstance(part, ast.NamedExpr) for part in inner
            ):
                found.append(f"{path}:{node.lineno}: an assignment within an expression")
            if isinstance(node, ast.IfExp) and any(isinstance(p, ast.IfExp) for p in inner):
                found.append(f"{path}:{node.lineno}: a conditional within a conditional")
            if isinstance(node, COMPREHENSIONS) and len(node.generators) > 2:
                found.append(f"{path}:{node.lineno}: {len(node.generators)} loops at once")
    return sorted(set(found))


def defined_names(module):
    """The public names that a module defines at its top: classes, functions and constants."""
    for node in module.body:
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            yield node.name
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
        for target in targets:
            parts = target.elts if isinstance(target, ast.Tuple) else [target]
            yield from (part.id for part in parts if isinstance(part, ast.Name))


def names_twice(root):
    """{name: files} of the public names that several modules define."""
    files = {}
    for path, module in _in_layers(root):
        for name in set(defined_names(module)):
            if not name.startswith("_") and name not in LOOKED_UP:
                files.setdefault(name, []).append(path.as_posix())
    return {name: sorted(paths) for name, paths in files.items() if len(paths) > 1}


def second_names(root):
    """Public names that several modules define and that the list of such names lacks; and names of
    the list that one module alone defines."""
    here = names_twice(root)
    listed = set(TWICE.read_text("utf-8").split())
    new = [
        f"{name} is defined in {', '.join(here[name])}" for name in sorted(set(here) - listed)
    ]
    if (root / TWICE.relative_to(TWICE.parents[2])).exists():
        new += [
            f"{name} is defined once: take it off {TWICE.name}" for name in listed - set(here)
        ]
    return new
