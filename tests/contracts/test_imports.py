"""Our modules are imported under one name, and the examples in their docstrings run."""

import doctest
import importlib
import sys
from pathlib import Path
from types import ModuleType

import pytest

from plumbob.engines.registry import engines, installed
from plumbob.tests.contracts.second_copies import second_copies
from plumbob.tests.contracts.tree import LAYERS, PACKAGE, layer_modules

ROOT = Path(__file__).parents[2]
MODULES = (PACKAGE, *layer_modules(ROOT))
ABSENT = tuple(  # parts of adapters, which import an engine that is not installed
    f"{PACKAGE}.engines.adapters.{engine.name}."
    for engine in engines().values()
    if not installed(engine)
)
FIRST = (  # what people call first: each has an example that runs
    "plumbob.analytic.systems.cone_pendulum",
    "plumbob.analytic.systems.manoeuvres.line_manoeuvre",
    "plumbob.analytic.systems.simple_pendulum",
    "plumbob.models.registry",
    "plumbob.models.scene",
    "plumbob.reports.judge.assertion",
)
SLOW = (f"{PACKAGE}.reports.audit_from_python",)  # whose example audits a model


def test_every_module_of_ours_has_one_name():
    assert second_copies(sys.modules, ROOT) == []


@pytest.mark.parametrize("name", [*LAYERS, f"{LAYERS[0]}.deep", "checkout", "checkout.models"])
def test_a_second_copy_is_seen(name, tmp_path):
    root = tmp_path / "checkout"
    copy = ModuleType(name)
    other = ModuleType(name)
    copy.__file__ = str(root / "models" / "__init__.py")
    other.__file__ = str(tmp_path / "somebody's" / "models" / "__init__.py")
    assert second_copies({name: copy, "plumbob.models": copy}, root) == [name]
    assert second_copies({name: other}, root) == []
    folder = ModuleType(name)  # a namespace package has no file
    folder.__path__ = [str(root / "models")]
    assert second_copies({name: folder}, root) == [name]


def _examples():
    """The modules that have examples, and those of FIRST."""
    for name in MODULES:
        file = ROOT.joinpath(*name.split(".")[1:])
        file = file / "__init__.py" if file.is_dir() else file.with_suffix(".py")
        if name in FIRST or (not name.startswith(ABSENT) and ">>>" in file.read_text("utf-8")):
            yield pytest.param(name, marks=pytest.mark.long if name in SLOW else ())


@pytest.mark.parametrize("name", [*_examples()])
def test_examples_in_docstrings_run(name):
    found = doctest.testmod(importlib.import_module(name))
    assert found.failed == 0
    assert found.attempted > 0


def test_every_module_is_imported():
    for name in MODULES:
        if not name.startswith(ABSENT):
            importlib.import_module(name)
