"""Contracts on imports: layers one way, no circles, engines behind their adapters."""

import ast
import graphlib
import subprocess
import sys
from pathlib import Path
from types import MappingProxyType

from plumbob.tests.contracts.tree import LAYERS, PACKAGE, imports, module_name, python

# parts of `analytic`: each may import those before it
THEORY = ("numerics", "systems", "errors")
ADAPTERS = ("engines", "adapters")
PAGE = (("reports", "view"), ("reports", "analyses"), ("reports", "records"))
# what runs an engine
RUNS = ("prepare", "prepared", "measure", "convergence_study", "run_study")
VIEW = PAGE[0]
ASKED = ("audit", "sweep")  # pages of answers that are worked out now, and are not stored
REGISTRY = f"{PACKAGE}.models.registry"  # imports every system and its exact motion when asked
MOTIONS = (*(f"{PACKAGE}.analytic.{part}" for part in THEORY), "mujoco", "pymunk", "scipy")
# all that `analytic` needs beside the language
LIBRARIES = ("gmpy2", "numpy", "numpy_quaddtype", "scipy")
HEAVY = (
    *(
        "dartpy",
        "dask",
        "distributed",
        "exudyn",
        "heyoka",
        "jax",
        "jinja2",
        "mujoco",
        "newton",
        "pinocchio",
    ),
    *("mujoco_warp", "plotly", "pybullet", "pydrake", "pymunk", "pytest", "warp"),
)
HOMES = MappingProxyType(  # other names
    {
        "dartpy": "dart",
        "jax": "mjx",
        "pydrake": "drake",
        "mujoco_warp": "mjwarp",
        "warp": ("mjwarp", "newton"),
    }
)


def _imports(root):
    """The imports of each file of the package."""
    for path, module in python(root):
        if path.parts[0] in LAYERS:
            for found in imports(path, module):
                yield path, found


def wrong_way(root):
    """Imports of a later layer, or of the tests."""
    wrong = []
    for path, found in _imports(root):
        layer = path.parts[0]
        top, _, inner = found.name.partition(".")
        target = inner.split(".")[0] if top == PACKAGE else top
        later = (*LAYERS[LAYERS.index(layer) + 1 :], "tests")
        wrong += [f"{path}:{found.line}: {layer} imports {found.name}"] * (target in later)
    return wrong


def foreign_libraries(root):
    """Imports in `analytic` of anything but the language, its few libraries and itself."""
    allowed = {*sys.stdlib_module_names, *LIBRARIES, PACKAGE}
    return [
        f"{path}:{found.line}: analytic imports {found.name}"
        for path, found in _imports(root)
        if path.parts[0] == "analytic" and found.name.split(".")[0] not in allowed
    ]


def circles(root):
    """The first circle of imports between our own modules, imports inside functions included, and
    names of types not."""
    return _circle(root, {name: name for name in map(module_name, dict(python(root)))})


def folder_circles(root):
    """The first circle of imports between the package's folders. The root folder is left out: its
    `check` is looked up when it is asked for. The `__init__.py` of an adapter counts as a folder:
    it offers the functions of all the adapter's folders."""
    inside = [path for path, _ in python(root) if path.parts[0] in LAYERS]
    offering = [path for path in inside if path.match("engines/adapters/*/__init__.py")]
    folders = {path: path if path in offering else path.parent for path in inside}
    return _circle(root, {module_name(path): folders[path].as_posix() for path in inside})


def _circle(root, nodes):
    """The first circle between the nodes that modules belong to."""
    graph = {node: set() for node in nodes.values()}
    for path, module in python(root):
        for found in imports(path, module):
            name = found.name if found.name in nodes else found.name.rpartition(".")[0]
            ends = nodes.get(found.module), nodes.get(name)
            if None not in ends and ends[0] != ends[1] and not found.types_alone:
                graph[str(ends[0])].add(str(ends[1]))
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return [" <- ".join(error.args[1])]
    return []


def commands_that_import_commands(root):
    """Imports of one command's module by another command: shared code lies in `shared`."""
    prefix = f"{PACKAGE}.reports.commands."
    wrong = []
    for path, found in _imports(root):
        module = found.name.removeprefix(prefix).split(".")[0]
        is_command = module not in (found.name.split(".")[0], "arguments", "shared")
        if path.parts[:2] == ("reports", "commands") and is_command:
            wrong.append(f"{path}:{found.line}: imports {found.name}")
    return wrong


def theory_upside_down(root):
    """Imports in `analytic` of a part that builds on the importing one: numerics <- systems <-
    errors."""
    return _upside_down(root, "analytic", THEORY)


def adapter_internals(root):
    """Imports of an adapter from outside `engines/adapters`, or of one adapter's folder from
    another's, but to name a type: `engines.registry` loads them by name."""
    wrong = []
    for path, found in _imports(root):
        inside = path.parts[:2] == ADAPTERS
        own = path.with_suffix("").parts[2] if inside else ""
        stem, _, inner = found.name.partition(f"{PACKAGE}.{'.'.join(ADAPTERS)}.")
        name = inner.split(".")[0]
        folder = (root / Path(*ADAPTERS) / name).is_dir() and name != own
        if inner and not stem and (folder or not inside) and not found.types_alone:
            wrong.append(f"{path}:{found.line}: imports {found.name}")
    return wrong


def engines_on_the_page(root):
    """Places where a page, or a finding on it, runs an engine in place of reading the study."""
    wrong = []
    for path, module in python(root):
        if path.parts[:2] not in PAGE:
            continue
        for node in ast.walk(module):
            if isinstance(node, ast.Call):
                name = ast.unparse(node.func).rpartition(".")[2]
                if name in RUNS:
                    wrong.append(f"{path}:{node.lineno}: calls {name}")
    return wrong


def motions_on_the_page(root):
    """Imports by which a page works out exact motions or theory: those of its own modules, and
    those that run when what it shows of a stored study is imported."""
    tree = {module_name(path): (path, module) for path, module in python(root)}
    pages = [name for name, (path, _) in tree.items() if path.parts[:2] == VIEW]
    wrong = [
        f"{tree[name][0]}:{found.line}: a page imports {found.name}"
        for name in pages
        for found in imports(*tree[name])
        if within(found.name, (*MOTIONS, REGISTRY))
    ]
    waiting = [name for name in pages if tree[name][0].parts[2] not in ASKED]
    loaded = set(waiting)
    while waiting:
        path, module = tree[waiting.pop()]
        for found in (found for found in imports(path, module) if found.on_import):
            target = found.name if found.name in tree else found.name.rpartition(".")[0]
            if within(found.name, MOTIONS):
                wrong.append(f"{path}:{found.line}: a page loads {found.name}")
            elif target in tree and target not in loaded:
                loaded.add(target)
                waiting.append(target)
    return wrong


# parts of `reports`: each may import those before it
REPORTS = ("judge", "advice", "records", "analyses", "view", "columns", "commands")


def reports_upside_down(root):
    """Imports in `reports` of a part that builds on the importing one: judge <- advice <- records
    <- analyses <- view <- columns <- commands."""
    return _upside_down(root, "reports", REPORTS)


def _upside_down(root, layer, parts):
    """Imports in a layer's folder of a part by another part that stands before it in `parts`."""
    wrong = []
    for path, found in _imports(root):
        if path.parts[0] == layer and path.parts[1] in parts:
            later = parts[parts.index(path.parts[1]) + 1 :]
            part = found.name.removeprefix(f"{PACKAGE}.{layer}.").split(".")[0]
            if part in later:
                wrong.append(f"{path}:{found.line}: imports {found.name}")
    return wrong


def functions_in_strings(root):
    """Strings that name a function of the package by its dotted path, in place of an import that
    tools follow. A system names the module of its model file, since plug-ins may add systems; a
    store names the classes of its results."""
    defined = set()
    for path, module in python(root):
        if path.parts[0] in LAYERS:
            defined |= {f"{module_name(path)}.{name}" for name in _defined_names(module)}
    wrong = []
    for path, module in python(root):
        if path.parts[0] in LAYERS:
            wrong += [
                f"{path}:{line}: {text!r} in place of an import"
                for line, text in _dotted_texts(module_name(path), module)
                if any(f"{prefix}{text}" in defined for prefix in ("", *_PREFIXES))
            ]
    return wrong


def _defined_names(module):
    """Yields the names that functions and assignments of a module define."""
    for node in module.body:
        if isinstance(node, ast.FunctionDef):
            yield node.name
        elif isinstance(node, ast.Assign):
            yield from map(ast.unparse, node.targets)


_PREFIXES = (f"{PACKAGE}.", *(f"{PACKAGE}.{layer}." for layer in LAYERS))


def _dotted_texts(name, module):
    """Yields the line and the text of each string in the module `name` that looks like a dotted
    path. `__name__` in a formatted string is replaced by `name`."""
    for node in ast.walk(module):
        text = ""
        if isinstance(node, ast.Constant):
            text = str(node.value)
        elif isinstance(node, ast.JoinedStr) and isinstance(node.values[-1], ast.Constant):
            own = ast.unparse(node).startswith("f'{__name__}.")
            text = f"{name}{node.values[-1].value}" if own else ""
        if "." in text and text.replace(".", "_").isidentifier():
            yield node.lineno, text


def within(name, packages):
    """Whether a module or a name in it belongs to one of these packages."""
    return any(name == package or name.startswith(f"{package}.") for package in packages)


def at_home(path, package):
    """Whether a file may import a heavy package outright: its engine's adapter, or the page."""
    if path.parts[0] == "tests":
        return True
    if package == "pytest":
        return path.parts == ("reports", "pytest_plugin.py")
    if package in ("jinja2", "plotly"):
        return path.parts == ("reports", "view", "page.py")
    home = HOMES.get(package, package)
    return path.parts[:2] == ("engines", "adapters") and path.parts[2].startswith(home)


def heavy_imports(root):
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


def heavy_when_imported(root):
    """The first module outside every heavy package's home whose import loads one after all."""
    names = [
        module_name(path)
        for path, _ in python(root)
        if path.parts[0] in LAYERS and not any(at_home(path, package) for package in HEAVY)
    ]
    command = [sys.executable, "-c", _PROBE, ",".join(HEAVY), *names]
    done = subprocess.run(command, cwd=root, check=False, capture_output=True, text=True)
    return [*done.stdout.splitlines(), *([done.stderr] if done.returncode else [])]
