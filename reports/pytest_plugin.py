"""A pytest plugin: `plumbob validate` as tests in any repository, and `check`, `audit` and
`assert_same_motion` as fixtures. Nothing of plumbob is loaded unless an option or a test asks for
it."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from plumbob.engines.method import Method
    from plumbob.models.scene import Scene
    from plumbob.reports.judge.verdict import Judgement
    from plumbob.reports.view.audit.results import MotionResult

PAIR_OPTIONS = ("scenes", "methods", "profile")
PROFILE_CHOICES = ("quick", "full")
# Options in [tool.plumbob] of pyproject.toml, with their types; `budget` [s] is that of an audit.
PROJECT_OPTIONS: Mapping[str, tuple[type, ...]] = MappingProxyType(
    {"scenes": (str,), "methods": (str,), "profile": (str,), "budget": (int, float)}
)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds the options that choose the runs, named as those of `plumbob validate`. With any of
    them, also as `scenes`, `methods` or `profile` in [tool.plumbob] of pyproject.toml, each chosen
    pair of a scene and a method becomes a test."""
    group = parser.getgroup("plumbob", "validation of physics engines (plumbob)")
    group.addoption("--plumbob-scenes", metavar="GLOB", help="validate these scenes: 'cone-*'")
    group.addoption(
        "--plumbob-methods", metavar="GLOB", help="validate these methods: 'mujoco/*'"
    )
    group.addoption(
        "--plumbob-profile", choices=PROFILE_CHOICES, help="validate the main scenes, or all"
    )


@pytest.fixture(scope="session")
def plumbob_check() -> Callable[..., Judgement]:
    """Returns `plumbob.check`: plumbob_check("cone-pendulum", "mujoco/rk4", step=1e-3) raises
    AssertionError if the verdict is not the expected one."""
    from plumbob import check

    return check


@pytest.fixture(scope="session")
def plumbob_same_motion() -> Callable[..., None]:
    """Returns `plumbob.assert_same_motion`: plumbob_same_motion(a, b, model, precision="float32")
    raises AssertionError if rounding does not explain what two recorded motions differ by."""
    from plumbob import assert_same_motion

    return assert_same_motion


@pytest.fixture(scope="session", name="audited")
def audit_with_kept_references(request: pytest.FixtureRequest) -> Callable[..., MotionResult]:
    """Returns `plumbob.audit` with two differences: certified motions are kept in pytest's cache
    between runs, and `budget` in [tool.plumbob] of pyproject.toml is the default. For example,
    audited("arm.xml", "sines").assert_within(metres=0.01)."""
    settings = _project_options(request.config)
    kept: dict[str, Any] = {name: settings[name] for name in ("budget",) if name in settings}
    cache = getattr(request.config, "cache", None)
    if cache is not None:
        kept["references"] = cache.mkdir("plumbob-references")

    def audited(model: Any, control: Any = "rest", **options: Any) -> MotionResult:
        """Returns the audit of a model; the arguments are those of `plumbob.audit`."""
        __tracebackhide__ = True
        from plumbob import audit
        from plumbob.analytic.parameters import ParameterError

        try:
            return audit(model, control, **{**kept, **options})
        except ParameterError as error:
            # The mistake is in the arguments: without plumbob's frames the failure shows the test.
            raise error.with_traceback(None) from None

    return audited


def _project_options(config: pytest.Config) -> Mapping[str, Any]:
    """Returns the table [tool.plumbob] of the project's pyproject.toml. Raises UsageError if it has
    an unknown option or a value of another type."""
    file = config.rootpath / "pyproject.toml"
    if not file.is_file():
        return {}
    try:
        table = tomllib.loads(file.read_text("utf-8")).get("tool", {}).get("plumbob", {})
    except (OSError, ValueError):
        return {}  # pytest itself reports a damaged file
    if not isinstance(table, dict):
        raise pytest.UsageError(f"tool.plumbob = {table!r}: must be a table, [tool.plumbob]")
    for name, value in table.items():
        wanted = PROJECT_OPTIONS.get(name)
        if wanted is None:
            raise _wrong_option(name, value, f"one of the options {', '.join(PROJECT_OPTIONS)}")
        if not isinstance(value, wanted) or isinstance(value, bool) or value == "":
            expected = "a number" if name == "budget" else "a text, not empty"
            raise _wrong_option(name, value, expected)
        if name == "profile" and value not in PROFILE_CHOICES:
            raise _wrong_option(name, value, " or ".join(PROFILE_CHOICES))
        if name == "budget" and not 0.0 < table[name] < math.inf:
            raise _wrong_option(name, value, "a number of seconds above 0")
    return table


def _wrong_option(name: str, value: Any, expected: str) -> pytest.UsageError:
    """Returns the error for an option in pyproject.toml."""
    return pytest.UsageError(f"[tool.plumbob] {name} = {value!r}: must be {expected}")


# This hook runs before pytest's -k and -m choose among the tests.
@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(session: pytest.Session, items: list[pytest.Item]) -> None:
    """Adds a test for each pair that the options choose."""
    config = session.config
    project = _project_options(config)
    scene_pattern, method_pattern, profile = (
        config.getoption(f"plumbob_{name}") or project.get(name) for name in PAIR_OPTIONS
    )
    if scene_pattern is method_pattern is profile is None:
        return
    from plumbob.analytic.parameters import ParameterError
    from plumbob.engines.registry import engine_of, installed
    from plumbob.engines.registry import methods as find_methods
    from plumbob.engines.study.runner import pairs
    from plumbob.models.registry import matching_scenes as find_scenes

    profile = profile or "quick"
    try:
        methods = find_methods(method_pattern or "*")
        chosen = pairs(find_scenes(scene_pattern or "*", profile), methods)
    except ParameterError as error:
        raise pytest.UsageError(f"--plumbob-{error}") from None
    for scene, method in chosen:
        engine = engine_of(method)
        if method_pattern is None and engine.optional and not installed(engine):
            continue
        name = f"{scene.name}-{method.name}"
        test = Validation.from_parent(
            session, name=name, scene=scene, method=method, profile=profile
        )
        items.append(test)


class Validation(pytest.Item):
    """A test of a scene with a method at all step sizes of a profile."""

    def __init__(self, *, scene: Scene, method: Method, profile: str, **rest: Any) -> None:
        super().__init__(**rest)
        self.scene, self.method, self.profile = scene, method, profile

    def runtest(self) -> None:
        """Fails with one line if the verdict is not expected; skips if the engine is not
        installed."""
        from plumbob.reports.judge.assertion import judged_runs
        from plumbob.reports.judge.expectations import surprise

        _, judged = judged_runs(self.scene, self.method, self.profile)
        judgement = judged.whole
        if judgement.verdict == "missing":
            pytest.skip(judgement.reason)
        message = surprise(self.scene, self.method, judgement)
        if message:
            message += f" ({judgement.reason})" if judgement.reason else ""
            pytest.fail(f"{self.scene.name} with {self.method.name}: {message}", pytrace=False)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Returns the test's file, no line, and the test's name, as pytest shows them."""
        return self.path, None, f"plumbob {self.name}"
