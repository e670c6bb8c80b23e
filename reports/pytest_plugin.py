"""A pytest plugin: `plumbob validate` as tests in any repository, and `check` and
`assert_same_motion` as fixtures. Nothing of plumbob is loaded unless an option or a test asks for
it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from plumbob.engines.method import Method
    from plumbob.models.scene import Scene
    from plumbob.reports.judge.verdict import Judgement

PYTEST_OPTIONS = ("plumbob_scenes", "plumbob_methods", "plumbob_profile")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds the options that choose the runs, named as those of `plumbob validate`. With any of
    them, each chosen pair of a scene and a method becomes a test."""
    group = parser.getgroup("plumbob", "validation of physics engines (plumbob)")
    group.addoption("--plumbob-scenes", metavar="GLOB", help="validate these scenes: 'cone-*'")
    group.addoption(
        "--plumbob-methods", metavar="GLOB", help="validate these methods: 'mujoco/*'"
    )
    group.addoption(
        "--plumbob-profile", choices=("quick", "full"), help="validate the main scenes, or all"
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


# This hook runs before pytest's -k and -m choose among the tests.
@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(session: pytest.Session, items: list[pytest.Item]) -> None:
    """Adds a test for each pair that the options choose."""
    scene_pattern, method_pattern, profile = (
        session.config.getoption(name) for name in PYTEST_OPTIONS
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
