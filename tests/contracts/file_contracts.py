"""Contracts on files: size, first line, name, state, complete systems, machine traces."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from plumbob.tests.contracts.tree import LAYERS, files, python

MOST_LINES = 401  # one whole idea: 100 to 400
FEW_LINES = 50
MOST_SHORT_FILES = 15
MOST_FILES = 15  # in a folder: it reads as a table of contents
TOP_LEVEL = {
    *LAYERS,
    "tests",
    *("CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE", "README.md"),
    *("__init__.py", "__main__.py", "py.typed"),
    *("Makefile", "constraints.txt", "pyproject.toml"),
}
DOT_FILES = {".ci", ".gitattributes", ".github", ".gitignore", ".pre-commit-config.yaml"}
VAGUE = re.compile(r"_*(common|data|helpers?|managers?|misc|stuff|tools?|util(s|ities|ity)?)")
MUTABLE = (ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp)
CONTAINERS = {"list", "dict", "set", "bytearray", "defaultdict", "Counter", "deque", "OrderedDict"}
# A name of one machine, or of a place that packages come from; URLs are not machine paths.
MACHINE_PATH = re.compile(r"(?<![\w.:/~)}-])/(tmp|work|root|home|Users|opt|mnt)/\w")
# A file that a text names, in the way of code or by a link; an address has a colon.
NAMED = re.compile(r"(?:`|\]\()([\w./-]+[.](?:py|md|xml|toml|png))(?:`|\))")
PACKAGE_INDEX = re.compile(
    r"pypi[.]org|python[h]osted|deb[.]debian|registry[.]npm|index[-]url|find[-]links"
)


def strangers(root: Path) -> list[str]:
    """Top-level names that the layout does not have."""
    return sorted({path.parts[0] for path in files(root)} - TOP_LEVEL - DOT_FILES)


def long_files(root: Path) -> list[str]:
    """Python files of more than 400 lines."""
    counts = {path: len((root / path).read_text("utf-8").splitlines()) for path, _ in python(root)}
    return [f"{path}: {lines} lines" for path, lines in counts.items() if lines >= MOST_LINES]


def short_files(root: Path) -> list[str]:
    """Python files of the package under 50 lines, `__init__`s aside, where there are more than 15
    of them: one idea is not split over several files."""
    short = []
    for path, _ in python(root):
        if path.parts[0] in LAYERS and path.name != "__init__.py":
            lines = len((root / path).read_text("utf-8").splitlines())
            short += [f"{path}: {lines} lines"] if lines < FEW_LINES else []
    return short if len(short) > MOST_SHORT_FILES else []


def crowded_folders(root: Path) -> list[str]:
    """Folders of more than 15 Python files, `__init__` aside."""
    counts = Counter(path.parent for path, _ in python(root) if path.name != "__init__.py")
    return [f"{path}: {count} files" for path, count in counts.items() if count > MOST_FILES]


def silent_files(root: Path) -> list[str]:
    """Python files with content whose first line does not say what they do."""
    silent = []
    for path, module in python(root):
        first, _, _ = (ast.get_docstring(module) or "").partition("\n")
        opens = (root / path).read_text("utf-8").startswith(('"""', 'r"""'))
        if module.body and not (opens and len(first.split()) >= 3):
            silent.append(f"{path}: first line {first!r}")
    return silent


def vague_names(root: Path) -> list[str]:
    """Modules and folders named after nothing in particular."""
    return [
        str(path)
        for path, _ in python(root)
        if any(VAGUE.fullmatch(part) for part in path.with_suffix("").parts)
    ]


def module_state(root: Path) -> list[str]:
    """Lists, dicts and sets bound outside functions, and `global` statements, in the package."""
    state = []
    for path, module in python(root):
        if path.parts[0] not in LAYERS:
            continue
        for statement in _outside_functions(module.body):
            if not isinstance(statement, (ast.Assign, ast.AnnAssign, ast.AugAssign)):
                continue
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            name = ", ".join(ast.unparse(target) for target in targets)
            if name != "__all__" and statement.value is not None and _mutable(statement.value):
                state.append(f"{path}:{statement.lineno}: {name} can be changed")
        state += [
            f"{path}:{node.lineno}: global {', '.join(node.names)}"
            for node in ast.walk(module)
            if isinstance(node, ast.Global)
        ]
    return state


def _outside_functions(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Yield statements that run on import, those of classes, conditions and loops included."""
    for statement in body:
        if isinstance(statement, (ast.FunctionDef, ast.AsyncFunctionDef)):
            continue
        yield statement
        for _, field in ast.iter_fields(statement):
            if isinstance(field, list) and field and isinstance(field[0], ast.stmt):
                yield from _outside_functions(field)
        for handler in getattr(statement, "handlers", ()):
            yield from _outside_functions(handler.body)


def _mutable(value: ast.expr) -> bool:
    """Whether an expression builds a container that others could change."""
    if isinstance(value, ast.Call):
        return ast.unparse(value.func).rpartition(".")[2] in CONTAINERS
    return isinstance(value, MUTABLE)


def incomplete_systems(root: Path) -> list[str]:
    """What a system's folder lacks: README with provenance, MJCF, scene, picture."""
    lacking = []
    for init in sorted((root / "models").glob("*/__init__.py")):
        folder, name = init.parent, init.parent.name
        wanted = ("README.md", f"{name}.xml", "scene.xml")
        lacking += [f"models/{name}: no {file}" for file in wanted if not (folder / file).is_file()]
        if not any(folder.glob("*.png")):
            lacking.append(f"models/{name}: no picture (*.png)")
        readme = folder / "README.md"
        described = readme.is_file() and re.search(
            r"(?im)^#+ .*provenance", readme.read_text("utf-8")
        )
        if not described and not (folder / "CHANGELOG.md").is_file():
            lacking.append(f"models/{name}: neither a section on provenance nor a CHANGELOG.md")
    return lacking


def machine_traces(root: Path) -> list[str]:
    """Lines of text files that name a place on one machine, or where packages come from."""
    traces = []
    for path in files(root):
        try:
            lines = (root / path).read_text("utf-8").splitlines()
        except UnicodeDecodeError:
            continue  # a picture
        for number, line in enumerate(lines, start=1):
            for match in filter(None, (MACHINE_PATH.search(line), PACKAGE_INDEX.search(line))):
                traces.append(f"{path}:{number}: {match.group()}")
    return traces


def missing_files(root: Path) -> list[str]:
    """Files that a README, or the theory of errors, names and that are not in the tree."""
    known = [f"/{path.as_posix()}" for path in files(root)]
    return [
        f"{path}: names {name}"
        for path in files(root)
        if path.name in ("README.md", "THEORY.md")
        for name in sorted(set(NAMED.findall((root / path).read_text("utf-8"))))
        if not any(file.endswith(f"/{name}") for file in known)
    ]
