"""Options and settings that every test shares."""

import gc
import os
import signal
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path

import pytest
from hypothesis import settings

from plumbob.engines.study.convergence import SEED
from plumbob.reports.commands.arguments import values
from plumbob.tests.contracts.second_copies import second_copies
from plumbob.tests.contracts.tree import layer_modules
from plumbob.tests.sharing.shared import share
from plumbob.tests.support.browser import driven
from plumbob.tests.support.schemas import held

# Machines differ in speed, so no deadline; the same examples every time, so that failures repeat.
settings.register_profile(
    "repeatable", deadline=None, derandomize=True, print_blob=True, max_examples=40
)
settings.register_profile("search", deadline=None, max_examples=2000)
# A job in the background may be started with interrupts ignored, and its processes with it.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


# Marks of the tests of which each suite runs a few cases alone, or none
LEFT_OUT = {"all": (), "whole": ("rare",), "short": ("rare", "long")}


def pytest_collection_modifyitems(config, items):
    """Put tests that take seconds first, so that none is left for one process at the end. A smaller
    suite leaves these tests out, except the cases that their marks keep."""
    from plumbob.tests.validation.representatives import left_out

    marks = LEFT_OUT[config.getoption("--suite")]
    items.sort(key=lambda item: not any(map(item.get_closest_marker, ("long", "rare"))))
    left = {item for mark in marks for item in left_out(items, mark)}
    if left:
        config.hook.pytest_deselected(items=list(left))
        items[:] = [item for item in items if item not in left]


def pytest_collection_finish():
    """The collector of garbage need not look again at what stays to the end."""
    gc.freeze()


WORKED_OUT = (
    "plumbob.analytic",
    "plumbob.engines.adapters",
    "plumbob.engines.study.measurement",
)


class _RootIsAFolder:
    """pytest would import the `__init__.py` beside `tests` under the name of the checkout."""

    def pytest_collect_directory(self, path, parent):
        """The root of the checkout as a plain folder."""
        root = path == parent.config.rootpath
        return pytest.Dir.from_parent(parent, path=path) if root else None


def pytest_configure(config):
    """Collect the root of the checkout, which is the package itself, as a plain folder."""
    config.pluginmanager.register(_RootIsAFolder())


@pytest.fixture(scope="session")
def browser():
    """Chromium under playwright, which can be started once a process and no more."""
    with driven() as found:
        yield found


@pytest.fixture(scope="session")
def shared(tmp_path_factory):
    """What the processes of this run have measured; not for a test that replaces a function."""
    from plumbob.tests.validation.measured_once import Shared

    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "measured"
    folder.mkdir(exist_ok=True)
    return Shared(folder)


@pytest.fixture(autouse=True, scope="session")
def _shares(tmp_path_factory):
    """The processes of one run share what is expensive to make."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        share(tmp_path_factory.getbasetemp().parent / "shared")


@pytest.fixture(autouse=True, scope="session")
def _json_keeps_to_its_schema():
    """Whatever a test has printed with --json is held against the command's schema."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(values, "print_json", held(values.print_json))
        yield


@pytest.fixture(autouse=True, scope="session")
def _same_examples(request):
    """hypothesis also tries the constants of the modules that are loaded: all of ours, so that what
    it tries depends neither on the order of tests nor on the process they run in."""
    if any(item.get_closest_marker("hypothesis") for item in request.session.items):
        for name in layer_modules(Path(__file__).parents[1]):
            with suppress(ImportError):  # of an engine that is not installed
                import_module(name)


@pytest.fixture(autouse=True, scope="session")
def _one_name_a_module():
    """Fail at the end of a run in which a module of ours was imported under a second name."""
    yield
    assert second_copies(sys.modules, Path(__file__).parents[1]) == []


@pytest.fixture
def monkeypatch(monkeypatch):
    """pytest's own; with a formula or an adapter that is replaced, and when it is back, what was
    worked out by it is forgotten."""
    usual = monkeypatch.setattr
    replaced = []

    def forgetting(target, *rest, **more):
        usual(target, *rest, **more)
        module = getattr(target, "__module__", getattr(target, "__name__", target))
        if str(module).startswith(WORKED_OUT):
            replaced.append(module)
            _forget()

    monkeypatch.setattr = forgetting
    yield monkeypatch
    monkeypatch.undo()
    if replaced:
        _forget()


def _forget():
    """Clear what is kept of references, theory, models and runs."""
    for name, module in list(sys.modules.items()):
        if name.startswith((*WORKED_OUT, "plumbob.tests.support.cases")):
            for kept in list(vars(module).values()):
                if hasattr(kept, "cache_clear") and getattr(kept, "__module__", "") == name:
                    kept.cache_clear()
    if registry := sys.modules.get("plumbob.models.registry"):
        registry._cached_case.cache_clear()


def pytest_addoption(parser):
    """Add what chooses the runs of tests/validation: the same words as `plumbob validate`."""
    group = parser.getgroup("plumbob", "which scenes and methods tests/validation runs")
    group.addoption(
        "--profile", choices=("quick", "full"), default="quick", help="how much to run"
    )
    group.addoption("--scenes", metavar="GLOB", default="*", help="scenes by name, as 'cone-*'")
    group.addoption(
        "--methods", metavar="GLOB", default="*", help="methods by name, as 'ode/*'"
    )
    group.addoption("--seed", type=int, default=SEED, help="draws one more step for each pair")
    group.addoption(
        "--suite",
        choices=("all", "whole", "short"),
        default="whole",
        help="whole: without what `make test-long` alone runs; short: also without what takes "
        "seconds, scenes and methods that stand for the rest",
    )
