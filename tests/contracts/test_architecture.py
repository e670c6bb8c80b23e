"""ARCHITECTURE.md names files, folders and functions that are there."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "ARCHITECTURE.md").read_text("utf-8")
PATH = re.compile(r"`((?:analytic|models|engines|reports|tests)(?:/[\w<>./-]+)?)`")
FUNCTION = re.compile(r"`(\w+)`\s+in\s+`([\w/]+\.py)`")
PATHS = sorted(set(PATH.findall(TEXT)))
FUNCTIONS = sorted(set(FUNCTION.findall(TEXT)))


def missing(path):
    """Whether no file or folder has this path; <engine> and the like stand for any name."""
    return not list(ROOT.glob(re.sub("<[a-z]+>", "*", path)))


@pytest.mark.parametrize("path", PATHS)
def test_each_path_exists(path):
    assert not missing(path)


@pytest.mark.parametrize(("name", "path"), FUNCTIONS)
def test_each_function_is_defined_in_its_file(name, path):
    body = ast.parse((ROOT / path).read_text("utf-8")).body
    defined = {node.name for node in body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    targets = [
        target for node in body if isinstance(node, ast.Assign) for target in node.targets
    ]
    targets += [node.target for node in body if isinstance(node, ast.AnnAssign)]
    defined |= {target.id for target in targets if isinstance(target, ast.Name)}
    assert name in defined


def test_the_text_names_files_and_functions():
    assert len(PATHS) >= 40
    assert len(FUNCTIONS) >= 10
    assert missing("engines/no_such_file.py")
