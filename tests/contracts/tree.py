"""The project's files, modules and imports, as the folder contracts see them."""

import ast
import subprocess
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

PACKAGE = "plumbob"  # the root of the tree, as an import package
LAYERS = ("analytic", "models", "engines", "reports")  # each may import those before it
Tree = tuple[tuple[Path, ast.Module], ...]


@dataclass(frozen=True)
class Import:
    """One imported module: who imports it, on which line, whether that runs on import, and whether
    it names types alone."""

    module: str
    name: str  # dotted, absolute; of `from a import b` it is "a.b"
    line: int
    on_import: bool
    types_alone: bool


def files(root):
    """Paths relative to `root` of what is or would be committed; without git, of every file."""
    if (root / ".git").exists():
        listing = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        out = subprocess.run(
            listing, cwd=root, check=True, capture_output=True, text=True
        ).stdout
        found = [Path(name) for name in out.split("\0") if name and (root / name).is_file()]
    else:
        found = [path.relative_to(root) for path in root.rglob("*") if path.is_file()]
    return tuple(sorted(path for path in found if "__pycache__" not in path.parts))


def texts(root):
    """Every text file with its text."""
    for path in files(root):
        with suppress(UnicodeDecodeError):  # a picture
            yield path, (root / path).read_text("utf-8")


@cache
def python(root):
    """Every Python file of the package and its tests with its syntax tree, read once."""
    chosen = [p for p in files(root) if p.suffix == ".py" and p.parts[0] != "build"]
    return tuple(
        (path, ast.parse((root / path).read_text("utf-8"), str(path))) for path in chosen
    )


def module_name(path):
    """Dotted name under which `path`, relative to the root, is imported."""
    parts = (PACKAGE, *path.with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def layer_modules(root):
    """Names of the modules of all layers."""
    chosen = (p for p in files(root) if p.suffix == ".py" and p.parts[0] in LAYERS)
    return tuple(module_name(path) for path in chosen)


@cache
def imports(path, module):
    """Every import in a file, those inside functions and type-checking blocks included."""
    return tuple(_imports(path, module))


def _imports(path, module):
    name = module_name(path)
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    for node, deferred, types_alone in _importing(module):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            stem = package[: len(package) - node.level + 1] if node.level else []
            base = ".".join([*stem, *([node.module] if node.module else [])])
            names = [f"{base}.{alias.name}" for alias in node.names]
        for imported in names:
            yield Import(name, imported, node.lineno, not deferred, types_alone)


def _importing(node, deferred=False, types_alone=False):
    """The import statements of a module or statement, each with whether it does not run when the
    module is imported, and whether it names types alone. Expressions hold none, and are not looked
    into."""
    if isinstance(node, (ast.Import, ast.ImportFrom)):
        yield node, deferred, types_alone
    deferred |= isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
    typing = isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")
    for part in ("body", "handlers", "orelse", "finalbody", "cases"):
        held = getattr(node, part, ())
        for inner in held if isinstance(held, list) else ():
            types = typing and part == "body"
            yield from _importing(inner, deferred or types, types_alone or types)
