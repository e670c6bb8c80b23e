"""The validation runs from an installed package in anybody's repository, by pytest's options."""

import os
import subprocess
import sys

import pytest

from plumbob.reports.pytest_plugin import _project_options
from plumbob.tests.outside.installed_packages import install, install_folder

PLUGIN = "plumbob.reports.pytest_plugin"
THEIRS = """
import sys
import models

def test_nothing_is_loaded_that_nobody_asks_for():
    assert models.NAME == "theirs"
    loaded = {name.partition(".")[0] for name in sys.modules}
    assert not loaded & {"numpy", "scipy", "mujoco"}
    assert not any(n.startswith(("plumbob.models", "plumbob.engines")) for n in sys.modules)
"""
FIXTURE = """
import pytest

def test_a_run(plumbob_check):
    assert plumbob_check("cone-pendulum", "ode/rk4", step=1e-3).verdict == "predicted"

def test_a_run_that_is_off(plumbob_check):
    with pytest.raises(AssertionError, match="misses the accuracy"):
        plumbob_check("cone-pendulum", "ode/euler", step=1e-3, within=1e-9)
"""


@pytest.fixture
def repository(tmp_path):
    """A repository with a package called `models`, and an environment with plumbob's plugin and an
    engine of theirs."""
    (tmp_path / "repository" / "models").mkdir(parents=True)
    (tmp_path / "repository" / "models" / "__init__.py").write_text(
        "NAME = 'theirs'\n", "utf-8"
    )
    install_folder(tmp_path / "site", "tiny_engine")
    install(tmp_path / "site", "plumbob-plugin", {"pytest11": {"plumbob": PLUGIN}})
    return tmp_path / "repository"


def session_of(repository, *options):
    """pytest in the repository, which finds the plugin by its entry point, with options by its
    name."""
    path = [str(repository.parent / "site"), os.environ.get("PYTHONPATH", "")]
    command = (sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-rA", *options)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path)}
    if options:  # other plugins take as long to load as the rest
        environment["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
        command = (*command, "-p", PLUGIN)
    return subprocess.run(
        command,
        cwd=repository,
        env=environment,
        check=False,
        capture_output=True,
        text=True,
    )


def test_a_plain_test_run_loads_nothing(repository):
    (repository / "test_theirs.py").write_text(THEIRS, "utf-8")
    done = session_of(repository)
    assert done.returncode == 0, done.stdout
    assert "1 passed" in done.stdout


@pytest.mark.long
def test_options_add_a_test_for_each_pair_and_the_fixture_is_there(repository):
    (repository / "test_theirs.py").write_text(FIXTURE, "utf-8")
    chosen = ("--plumbob-scenes", "simple-pendulum/free-*", "--plumbob-methods", "tiny,ode/rk4")
    done = session_of(repository, *chosen, "-k", "tiny or run", "-W", "error")
    assert done.returncode == 0, done.stdout
    for name in ("free-small-tiny/euler", "free-large-tiny/euler"):
        assert f"simple-pendulum/{name}" in done.stdout
    assert "4 passed, 2 deselected" in done.stdout
    assert "no theory" not in done.stdout


@pytest.mark.long
def test_an_unexpected_verdict_fails_with_a_line(repository):
    module = repository.parent / "site" / "tiny_engine.py"
    text = module.read_text("utf-8")
    module.write_text(text.replace("step * pendulum", "1.01 * step * pendulum"), "utf-8")
    chosen = ("--plumbob-scenes", "simple-pendulum/free-large", "--plumbob-methods", "tiny")
    done = session_of(repository, *chosen, "--junitxml", "found.xml")
    assert done.returncode == 1
    assert "with tiny/euler: not-converging, expected predicted" in done.stdout
    assert "Traceback" not in done.stdout
    assert "tiny/euler" in (repository / "found.xml").read_text("utf-8")


AUDITED = """
def test_a_model_that_is_off(audited):
    audited("rod.xml", duration=0.1).assert_within(metres=1e-9)

def test_a_model_that_is_missing(audited):
    audited("none.xml")
"""
ROD = """<mujoco><worldbody><body><joint axis="0 1 0"/><geom size=".1" pos=".5 0 0"/></body>
</worldbody></mujoco>"""


@pytest.mark.rare
def test_references_are_kept_between_runs_and_failures_show_the_test_alone(repository):
    """The second session reads the reference that the first one kept, and says the same."""
    (repository / "rod.xml").write_text(ROD, "utf-8")
    (repository / "test_theirs.py").write_text(AUDITED, "utf-8")
    (repository / "pyproject.toml").write_text("[tool.plumbob]\nbudget = 3\n", "utf-8")
    first = session_of(repository, "-p", "cacheprovider", "-k", "off")
    assert first.returncode == 1
    (kept,) = (repository / ".pytest_cache" / "d" / "plumbob-references").iterdir()
    written = kept.stat().st_mtime_ns
    second = session_of(repository, "-p", "cacheprovider", "-k", "off")
    failures = [
        [line for line in of.stdout.splitlines() if "m off" in line] for of in (first, second)
    ]
    assert failures[0] == failures[1] != []
    assert kept.stat().st_mtime_ns == written
    assert 'audited("rod.xml"' in second.stdout
    assert "def assert_within" not in second.stdout
    assert "/engines/" not in second.stdout
    missing = session_of(repository, "-k", "missing")
    assert "ParameterError: model = 'none.xml': must be a file that exists" in missing.stdout
    assert "/engines/" not in missing.stdout


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("[tool]\nplumbob = 3", "tool.plumbob = 3: must be a table"),
        ("[[tool.plumbob]]\nbudget = 3", "tool.plumbob = [{'budget': 3}]: must be a table"),
        ("scenes = ''", "[tool.plumbob] scenes = '': must be a text, not empty"),
        ("bugdet = 3", "[tool.plumbob] bugdet = 3: must be one of the options scenes,"),
        ("scenes = 3", "[tool.plumbob] scenes = 3: must be a text"),
        ("budget = true", "[tool.plumbob] budget = True: must be a number"),
        ("budget = -1", "[tool.plumbob] budget = -1: must be a number of seconds above 0"),
        ("budget = nan", "[tool.plumbob] budget = nan: must be a number of seconds above 0"),
        ("profile = 'long'", "[tool.plumbob] profile = 'long': must be quick or full"),
    ],
)
def test_a_wrong_option_of_a_project_is_one_line(table, said, tmp_path):
    class Config:
        rootpath = tmp_path

    header = "" if table.startswith("[") else "[tool.plumbob]\n"
    (tmp_path / "pyproject.toml").write_text(f"{header}{table}\n", "utf-8")
    with pytest.raises(pytest.UsageError) as raised:
        _project_options(Config)
    assert str(raised.value).startswith(said)
