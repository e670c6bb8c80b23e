"""Contracts on files: size, first line, name, state, complete systems, machine traces."""

import ast
import re

from plumbob.tests.contracts.tree import LAYERS, files, python, texts

MOST_LINES, MOST_NAMES = 60, 15  # of a function: it fits a screen, and one remembers its names
LONG, TANGLED = 0, 19
TOP_LEVEL = {
    *LAYERS,
    "tests",
    *(
        "ARCHITECTURE.md",
        "CHANGELOG.md",
        "CITATION.cff",
        "SKILL.md",
        "CONTRIBUTING.md",
        "LICENSE",
        "README.md",
    ),
    *("__init__.py", "__main__.py", "py.typed"),
    *("Makefile", "constraints.txt", "pyproject.toml"),
}
DOT_FILES = {".ci", ".gitattributes", ".github", ".gitignore"}
DOT_FILES |= {".pre-commit-config.yaml", ".pre-commit-hooks.yaml"}
VAGUE = re.compile(r"_*(common|data|helpers?|managers?|misc|stuff|tools?|util(s|ities|ity)?)")
MUTABLE = (ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp)
CONTAINERS = {
    "list",
    "dict",
    "set",
    "bytearray",
    "defaultdict",
    "Counter",
    "deque",
    "OrderedDict",
}
# A name of one machine, or of a place that packages come from; URLs are not machine paths.
MACHINE_PATH = re.compile(r"(?<![\w.:/~)}-])/(tmp|work|root|home|Users|opt|mnt)/\w")
# A file that a text names in the way of code, and one that it links to; an address has a colon.
NAMED = re.compile(r"`([\w./-]+[.](?:py|md|xml|toml|png))`")
LINKED = re.compile(r"\]\(([\w./-]+)\)")
TEST = re.compile(r"(?:`|::)(test_\w+)[`'\"]")
PACKAGE_INDEX = re.compile(
    r"pypi[.]org|python[h]osted|deb[.]debian|registry[.]npm|index[-]url|find[-]links"
)


def strangers(root):
    """Top-level names that the layout does not have."""
    return sorted({path.parts[0] for path in files(root)} - TOP_LEVEL - DOT_FILES)


def long_functions(root):
    """Functions of more than 60 lines, or with more than 15 names of their own, where there are
    more of them than there were."""
    long = []
    tangled = []
    for path, module in python(root):
        if path.parts[0] not in LAYERS:
            continue
        for node in ast.walk(module):
            if isinstance(node, ast.FunctionDef):
                where = f"{path}:{node.lineno} {node.name}"
                long += [where] if (node.end_lineno or 0) - node.lineno >= MOST_LINES else []
                stored = (n for n in ast.walk(node) if isinstance(n, ast.Name))
                names = {n.id for n in stored if isinstance(n.ctx, ast.Store)}
                tangled += [where] if len(names) > MOST_NAMES else []
    return [*(long if len(long) > LONG else []), *(tangled if len(tangled) > TANGLED else [])]


def silent_files(root):
    """Python files with content whose first line does not say what they do."""
    silent = []
    for path, module in python(root):
        first, _, _ = (ast.get_docstring(module) or "").partition("\n")
        opens = (root / path).read_text("utf-8").startswith(('"""', 'r"""'))
        if module.body and not (opens and len(first.split()) >= 3):
            silent.append(f"{path}: first line {first!r}")
    return silent


def vague_names(root):
    """Modules and folders named after nothing in particular."""
    return [
        str(path)
        for path, _ in python(root)
        if any(VAGUE.fullmatch(part) for part in path.with_suffix("").parts)
    ]


def module_state(root):
    """Lists, dicts and sets bound outside functions, and `global` statements, in the package."""
    state = []
    for path, module in python(root):
        if path.parts[0] not in LAYERS:
            continue
        for statement in _outside_functions(module.body):
            if not isinstance(statement, (ast.Assign, ast.AnnAssign, ast.AugAssign)):
                continue
            targets = (
                statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            )
            name = ", ".join(ast.unparse(target) for target in targets)
            if name != "__all__" and statement.value is not None and _mutable(statement.value):
                state.append(f"{path}:{statement.lineno}: {name} can be changed")
        state += [
            f"{path}:{node.lineno}: global {', '.join(node.names)}"
            for node in ast.walk(module)
            if isinstance(node, ast.Global)
        ]
    return state


def _outside_functions(body):
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


def _mutable(value):
    """Whether an expression builds a container that others could change."""
    if isinstance(value, ast.Call):
        return ast.unparse(value.func).rpartition(".")[2] in CONTAINERS
    return isinstance(value, MUTABLE)


def incomplete_systems(root):
    """What a system's folder lacks: README with provenance, MJCF, scene, picture."""
    lacking = []
    for init in sorted((root / "models").glob("*/__init__.py")):
        folder = init.parent
        name = init.parent.name
        wanted = ("README.md", f"{name}.xml", "scene.xml")
        lacking += [
            f"models/{name}: no {file}" for file in wanted if not (folder / file).is_file()
        ]
        if not any(folder.glob("*.png")):
            lacking.append(f"models/{name}: no picture (*.png)")
        readme = folder / "README.md"
        described = readme.is_file() and re.search(
            r"(?im)^#+ .*provenance", readme.read_text("utf-8")
        )
        if not described and not (folder / "CHANGELOG.md").is_file():
            lacking.append(f"models/{name}: neither a section on provenance nor a CHANGELOG.md")
    return lacking


def machine_traces(root):
    """Lines of text files that name a place on one machine, or where packages come from."""
    traces = []
    for path, text in texts(root):
        for number, line in enumerate(text.splitlines(), start=1):
            for match in filter(None, (MACHINE_PATH.search(line), PACKAGE_INDEX.search(line))):
                traces.append(f"{path}:{number}: {match.group()}")
    return traces


def missing_files(root):
    """Files and tests that a README, the theory of errors or the list of statements names or links
    to and that are not in the tree. A link leads there from the folder of its text."""
    known = [f"/{path.as_posix()}" for path in files(root)]
    defined = (node for _, module in python(root) for node in ast.walk(module))
    tests = {node.name for node in defined if isinstance(node, ast.FunctionDef)}
    missing = []
    for path in files(root):
        if path.name in ("README.md", "THEORY.md", "statements.toml"):
            text = (root / path).read_text("utf-8")
            lost = {
                n for n in NAMED.findall(text) if not any(k.endswith(f"/{n}") for k in known)
            }
            lost |= {n for n in LINKED.findall(text) if not (root / path.parent / n).exists()}
            lost |= set(TEST.findall(text)) - tests
            missing += [f"{path}: names {name}" for name in sorted(lost)]
    return missing
