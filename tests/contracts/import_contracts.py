"""Folder contracts on imports: the way through the rooms, no circles, heavy packages late."""

from __future__ import annotations

import graphlib
import subprocess
import sys
from pathlib import Path

from plumbob.tests.contracts.tree import PACKAGE, ROOMS, imports, module_name, python

LIBRARIES = ("numpy", "numpy_quaddtype", "scipy")  # all that `analytic` needs beside the language
HEAVY = ("dask", "distributed", "heyoka", "jinja2", "mujoco", "plotly", "pymunk", "pytest")


def wrong_way(root: Path) -> list[str]:
    """Imports of a room that comes later, or of the tests."""
    wrong = []
    for path, module in python(root):
        if (room := path.parts[0]) not in ROOMS:
            continue
        allowed = ROOMS[: ROOMS.index(room) + 1]
        for found in imports(path, module):
            top, _, inner = found.name.partition(".")
            target = inner.split(".")[0] if top == PACKAGE else top
            if target in (*ROOMS, "tests") and target not in allowed:
                wrong.append(f"{path}:{found.line}: {room} imports {found.name}")
    return wrong


def foreign_libraries(root: Path) -> list[str]:
    """Imports in `analytic` of anything but the language, its few libraries and itself."""
    allowed = {*sys.stdlib_module_names, *LIBRARIES, PACKAGE}
    return [
        f"{path}:{found.line}: analytic imports {found.name}"
        for path, module in python(root)
        if path.parts[0] == "analytic"
        for found in imports(path, module)
        if found.name.split(".")[0] not in allowed
    ]


def circles(root: Path) -> list[str]:
    """The first circle of imports between our own modules, imports inside functions included."""
    tree = python(root)
    names = {module_name(path) for path, _ in tree}
    graph: dict[str, set[str]] = {name: set() for name in names}
    for path, module in tree:
        for found in imports(path, module):
            target = found.name if found.name in names else found.name.rpartition(".")[0]
            if target in names and target != found.module:
                graph[found.module].add(target)
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return [" <- ".join(error.args[1])]
    return []


def at_home(path: Path, package: str) -> bool:
    """Whether a file may import a heavy package outright: its engine's adapter, or the page."""
    if path.parts[0] == "tests":
        return True
    if package in ("jinja2", "plotly"):
        return path.parts == ("reports", "view", "page.py")
    return path.parts[:2] == ("engines", "adapters") and path.parts[2].startswith(package)


def heavy_imports(root: Path) -> list[str]:
    """Heavy packages imported outside functions anywhere but at home."""
    return [
        f"{path}:{found.line}: imports {package} outside a function"
        for path, module in python(root)
        for found in imports(path, module)
        if found.on_import
        and (package := found.name.split(".")[0]) in HEAVY
        and not at_home(path, package)
    ]


_PROBE = """
import importlib, importlib.util, sys
spec = importlib.util.spec_from_file_location(  # whatever the tree's folder is called
    "plumbob", "__init__.py", submodule_search_locations=["."])
package = sys.modules["plumbob"] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(package)
for name in sys.argv[2:]:
    importlib.import_module(name)
    loaded = [heavy for heavy in sys.argv[1].split(",") if heavy in sys.modules]
    if loaded:
        print(f"{name}: importing it loads {', '.join(loaded)}")
        break
"""


def heavy_when_imported(root: Path) -> list[str]:
    """The first module outside every heavy package's home whose import loads one after all."""
    names = [
        module_name(path)
        for path, _ in python(root)
        if path.parts[0] in ROOMS and not any(at_home(path, package) for package in HEAVY)
    ]
    command = [sys.executable, "-c", _PROBE, ",".join(HEAVY), *names]
    done = subprocess.run(command, cwd=root, check=False, capture_output=True, text=True)
    return [*done.stdout.splitlines(), *([done.stderr] if done.returncode else [])]
