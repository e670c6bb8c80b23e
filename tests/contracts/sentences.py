"""Contracts on how code reads: docstrings and comments are no fragments, a statement holds one
idea, a public name stands for one thing, and a name in a text exists."""

import ast
import io
import re
import tokenize

from plumbob.tests.contracts.tree import LAYERS, files, python

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
TWICE = "tests/contracts/names_twice.txt"


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


# A value alone in parentheses with its comment, and an annotation with a comment after its end
TORN = re.compile(
    r"^( *)[\w.]+(?:: [^\n=(]+)? = \(\n +[^\n#,]+  # [^\n]+\n\1\)$"
    r"|^( *)[\w.]+: \w+\[\n[^\n#]+\n\2\][^\n#]*  # ",
    re.MULTILINE,
)


def torn_comments(root):
    """Comments behind a statement for which the formatter broke the statement: they belong above
    it."""
    found = []
    for path, _ in _in_layers(root):
        text = (root / path).read_text("utf-8")
        for torn in TORN.finditer(text):
            line = text.count("\n", 0, torn.start()) + 1
            found.append(f"{path}:{line}: put the comment above the statement")
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
    listed = set((root / TWICE).read_text("utf-8").split())
    new = [
        f"{name} is defined in {', '.join(here[name])}" for name in sorted(set(here) - listed)
    ]
    gone = sorted(listed - set(here))
    return [*new, *(f"{name} is defined once: take it off {TWICE}" for name in gone)]


# names that a text takes from code: any between backquotes, and constants of several words
QUOTED_NAME = re.compile(r"`([A-Za-z_]\w*)`|\b([A-Z]{2,}(?:_[A-Z0-9]+)+)\b")
NAME = re.compile(r"[A-Za-z_]\w*")
DATA = (".toml", ".xml", ".js", ".jinja", ".css")  # suffixes of files that hold names too


def unknown_names(root):
    """Names in docstrings and comments of the layers, and in the theory of errors, that neither
    code nor data of the tree has."""
    known = _names_of_code(root) | _names_of_data(root)
    wrong = []
    for path, module in _in_layers(root):
        for line, text in (*_docstrings(module), *_comments((root / path).read_text("utf-8"))):
            wrong += [f"{path}:{line}: names {name}" for name in _quoted(text) - known]
    for path in files(root):
        if path.name == "THEORY.md":
            text = (root / path).read_text("utf-8")
            wrong += [f"{path}: names {name}" for name in _quoted(text) - known]
    return sorted(wrong)


def _quoted(text):
    """The names that a text takes from code."""
    return {one or other for one, other in QUOTED_NAME.findall(text)}


def _docstrings(module):
    """Each docstring of a module, and each text that stands alone as a statement, with its line."""
    for node in ast.walk(module):
        value = node.value if isinstance(node, ast.Expr) else None
        if isinstance(value, ast.Constant) and isinstance(value.value, str):
            yield node.lineno, value.value


def _comments(text):
    """Each comment of a Python file with its line."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string


def _names_of_code(root):
    """The names that the code of the tree uses, and all that could be names in its strings but
    docstrings."""
    names = set()
    for _, module in python(root):
        alone = {
            id(node.value)
            for node in ast.walk(module)
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        }
        for node in ast.walk(module):
            for field in ("id", "attr", "arg", "name", "asname", "module"):
                name = getattr(node, field, None)
                if isinstance(name, str):
                    names.update(name.split("."))
            is_text = isinstance(node, ast.Constant) and isinstance(node.value, str)
            if is_text and id(node) not in alone:
                names.update(NAME.findall(node.value))
    return names


def _names_of_data(root):
    """All that could be names in templates and files of data, and names of files and folders."""
    names = set()
    for path in files(root):
        names |= {path.stem, *path.parts}
        if path.suffix in DATA or path.parts[:2] == ("reports", "templates"):
            names.update(NAME.findall((root / path).read_text("utf-8")))
    return names
