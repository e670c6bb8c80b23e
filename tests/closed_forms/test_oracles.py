"""Each system's exact motion is held to an answer that shares no code with it: oracles.toml."""

import ast
import tomllib
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path

import pytest

from plumbob.models.registry import case_of, find_system, systems

ROOT = Path(__file__).parents[2]
ORACLES = tomllib.loads(Path(__file__).with_name("oracles.toml").read_text("utf-8"))
OURS = "plumbob."
TESTS = "plumbob.tests."
# Of the product, of types alone: nothing is computed by it.
TYPES = ("Array",)
OF_PRODUCT = ("", "")


@cache
def module(path):
    """What a file of tests defines, by name, and what each name that it imports is."""
    tree = ast.parse((ROOT / path).read_text("utf-8"))
    made = {n.name: n for n in tree.body if isinstance(n, ast.FunctionDef | ast.ClassDef)}
    for node in tree.body:
        if isinstance(node, ast.Assign):
            made |= {n.id: node for n in ast.walk(node.targets[0]) if isinstance(n, ast.Name)}
    imported = {
        name.asname or name.name: (node.module, name.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for name in node.names
    }
    return made, imported


def file_of(source):
    """The file of a module of tests, or None."""
    path = source.removeprefix(OURS).replace(".", "/") + ".py"
    return path if source.startswith(TESTS) and (ROOT / path).is_file() else None


def meant(path, node):
    """What a name, or a name of an imported module of tests, stands for: its file and name there,
    or that it is of the product."""
    made, imported = module(path)
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        file = file_of(".".join(imported.get(node.value.id, ("", ""))))
        return (file, node.attr) if file else None
    if not isinstance(node, ast.Name):
        return None
    source, original = imported.get(node.id, ("", ""))
    if node.id in made:
        return path, node.id
    if file := file_of(source):
        return file, original
    whole = file_of(f"{source}.{original}")
    return (
        OF_PRODUCT if source.startswith(OURS) and not whole and original not in TYPES else None
    )


def reached(path, name):
    """The syntax of a function with all of tests that it uses, and the names of the product that
    they use."""
    waiting, known, product = [(path, name)], {}, set()
    while waiting:
        at = waiting.pop()
        if at in known:
            continue
        known[at] = module(at[0])[0][at[1]]
        for node in ast.walk(known[at]):
            found = meant(at[0], node)
            product |= {node.id} if found is OF_PRODUCT else set()
            waiting += [found] if found not in (None, OF_PRODUCT) else []
    return tuple(known.values()), product


def computed(problem):
    """Names of all that a problem, and the records in it, compute, which are no fields of them."""
    path = getattr(getattr(problem, "motion", None), "path", None)  # whose pieces are numbers
    waiting, known, names, data = [problem, path], set(), set(), set()
    while waiting:
        record = waiting.pop()
        waiting += record if isinstance(record, tuple) else []
        if not is_dataclass(record) or type(record) in known:
            continue
        known.add(type(record))
        data |= {field.name for field in fields(record)}
        names |= {name for name in dir(type(record)) if not name.startswith("_")}
        waiting += [getattr(record, field.name) for field in fields(record)]
    return names - data


def test_every_system_has_one():
    assert ORACLES.keys() == set(systems())


@pytest.mark.parametrize("name", ORACLES)
def test_it_shares_no_code_with_what_it_tests(name):
    row = ORACLES[name]
    path, _, test = row["test"].partition("::")
    assert test in module(path)[0]
    used = reached(path, test)[0]
    theirs = computed(case_of(find_system(name).scenes[0]).problem)
    for oracle in row["oracles"]:
        path, _, function = oracle.partition("::")
        syntax, product = reached(path, function)
        recorded = "recorded" in path  # whose answers are in a file that it has written
        assert recorded or module(path)[0][function] in used, (
            f"{oracle} is not used by the test"
        )
        assert not product, f"{oracle} uses {product} of the product"
        nodes = [node for of in syntax for node in ast.walk(of)]
        own = {node.name for node in nodes if isinstance(node, ast.FunctionDef)}
        read = {node.attr for node in nodes if isinstance(node, ast.Attribute)} - own
        assert not read & theirs, f"{oracle} reads {read & theirs}, which the product computes"
    assert row["how"]
