"""Certificates held against a model's own integrators at steps 256 to 4096 times smaller: of two
legs, and of the files that dm_control and gymnasium distribute (few in the quick profile)."""

from dataclasses import dataclass

import numpy as np
import pytest

from plumbob.analytic.reference import Array
from plumbob.engines.audit.reference import RESOLVED, running_maximum
from plumbob.engines.own_motion import NotCertifiable
from plumbob.tests.audit.robots.robot_files import FILES, file_audit

BUDGETS = {"quick": 10.0, "full": 60.0}  # [s] of processor time for an audit
LIMITS = {"quick": 5.0, "full": 20.0}  # [s] of processor time for a run of small steps
FINEST, LEAST = 4096, 256  # times smaller than the own step
MANY = 1e3  # roundings of a motion that up to a million steps may add up to, in a random walk
# From a step to a quarter of it an error that goes as a power from a half on is at least halved:
# what is left of it is at most what the two differ by.
QUARTER = 4
HOLDS, OUTSIDE, OPEN = "holds", "outside", "not outside: steps tell less"


@dataclass(frozen=True)
class Confirmation:
    """What small steps of one integrator make of a motion that is certified, at the ends of the
    control periods."""

    integrator: str
    finer: int  # times smaller than the own step
    apart: Array  # [m] from the reference at most so far
    scatter: Array  # [m] how far these steps may be from their own limit
    error: float  # [m] of the own step, held against them


def confirmations(found, limit):
    """Euler and RK4 at steps as small as `limit` [s] of processor time each allow."""
    model = found.model
    script = found.script
    steps = found.found
    count = steps.index + 1

    def motion(integrator, factor):
        run = model.stepped(script, integrator, factor * steps.own.parts)
        return model.corners(run.states[:count]), run.seconds

    own, _ = motion(found.integrator, 1)
    confirmed = []
    for integrator in ("euler", "rk4"):
        seconds = motion(integrator, QUARTER**2)[1] / QUARTER**2
        most = limit / (seconds * (1 + 1 / QUARTER))
        factor = next((f for f in (FINEST, FINEST // QUARTER) if f <= most), LEAST)
        fine, coarse = (motion(integrator, f)[0] for f in (factor, factor // QUARTER))
        apart = so_far(fine, found.reference.corners[:count])
        error = float(so_far(own, fine)[-1])
        confirmed.append(Confirmation(integrator, factor, apart, so_far(fine, coarse), error))
    return sorted(confirmed, key=lambda c: c.scatter[-1])


def verdict(found, confirmed):
    """Whether the certificate has the small steps of both integrators outside, or the better ones
    tell less than it does."""
    best = confirmed[0]
    rounding = MANY * np.finfo(float).eps * np.abs(found.reference.corners).max()
    known = found.reference.uncertainty[: best.apart.size]
    if np.all([c.apart > known + c.scatter + rounding for c in confirmed], axis=0).any():
        return OUTSIDE
    tells = best.scatter[-1] <= max(RESOLVED * known[-1], rounding)
    return HOLDS if tells else OPEN


def so_far(one, other):
    """The largest displacement [m] of any corner so far between two motions, shape (n,)."""
    return running_maximum(np.linalg.norm(one - other, axis=2))


QUICK = ("hopper rest", "walker rest", "inverted_pendulum sines", "swimmer sines")
REFUSED = {"dog": "the noslip solver", "lqr": "no degree of freedom"}
SHORT = {"point sines": "rounding decides"}  # what is not certified, and why
SHORTEST = 0.2  # [s]: a shorter certificate is none


@pytest.mark.parametrize("control", ["rest", "sines"])
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_certificate_has_no_small_steps_outside(path, control, request):
    profile = request.config.getoption("--profile")
    case = f"{path.stem} {control}"
    if profile == "quick" and case not in QUICK:
        pytest.skip("in the full profile")
    if path.stem in REFUSED:
        with pytest.raises(NotCertifiable, match=REFUSED[path.stem]):
            file_audit(path, control, BUDGETS[profile])
        return
    found = file_audit(path, control, BUDGETS[profile])
    assert found.complete or found.reference.why
    if case in SHORT:
        assert SHORT[case] in found.reference.why
        return
    assert found.until >= SHORTEST
    assert not found.resolved or found.script.times[found.resolved_index] >= SHORTEST * (
        1 - 1e-9
    )
    assert verdict(found, confirmations(found, LIMITS[profile])) != OUTSIDE
