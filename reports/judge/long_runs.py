"""Verdicts on long runs: is the time until an error reaches a level the predicted time?"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from plumbob.analytic.stability import LEVELS
from plumbob.engines.study.long_runs import LongRunSearch, MeasuredLongRun
from plumbob.reports.judge.stability import LimitVerdict

# The measured time may differ from the predicted time by WITHIN times the predicted time plus
# PERIODS periods. A run notices the crossing of a level only at the next peak of the error, which
# comes once a period. Both numbers are calibrated: tests/study/test_long_runs.py fails with smaller
# and with larger ones.
WITHIN, PERIODS = 0.1, 2.0
JUDGED_LEVELS = LEVELS[
    :2
]  # levels that are judged: the last level is far beyond the linear range


@dataclass(frozen=True)
class JudgedLongRun:
    """A long run with its verdict: `measured` if no theory predicts its times."""

    search: LongRunSearch
    found: MeasuredLongRun
    verdict: LimitVerdict
    surprise: str = ""  # why the verdict is not as expected

    def record(self) -> dict[str, Any]:
        """The record that `plumbob stability --long --json` prints, in SI units."""
        found = self.found
        predicted = self.found.predicted
        return {
            "scene": self.search.scene,
            "method": self.search.method,
            "step": found.step,
            "period": found.period,
            "growth": predicted and predicted.growth,
            "rate": predicted and predicted.rate,
            "times": [
                {
                    "error": level,
                    "predicted": predicted and predicted.times[level],
                    "measured": found.times.get(level),
                }
                for level in LEVELS
            ],
            "followed": found.followed,
            "why": found.why or found.stopped,
            "energy": found.energy,
            "energy_rate": found.energy_rate,
            "energy_rate_predicted": predicted and predicted.energy_rate,
            "verdict": self.verdict,
            "expected": not self.surprise,
        }


def judged_long_run(search: LongRunSearch, measured: MeasuredLongRun) -> JudgedLongRun:
    """Returns a measured long run with its verdict."""
    if measured.predicted is None:
        return JudgedLongRun(search, measured, "measured")
    mismatch = "; ".join(_time_mismatches(measured))
    verdict: LimitVerdict = "off-prediction" if mismatch else "predicted"
    return JudgedLongRun(search, measured, verdict, mismatch)


def _time_mismatches(run: MeasuredLongRun) -> Iterator[str]:
    """Yields a message for each level whose time is not the predicted one."""
    assert run.predicted is not None
    margin = PERIODS * run.period
    for level in JUDGED_LEVELS:
        predicted = run.predicted.times[level]
        measured = run.times.get(level)
        earliest = (1.0 - WITHIN) * predicted - margin
        latest = (1.0 + WITHIN) * predicted + margin
        if measured is None and latest < run.followed:
            yield (
                f"no error of {level:.0%} in {run.followed:.4g} s, predicted at {predicted:.4g} s"
            )
        elif measured is not None and not earliest <= measured <= latest:
            wanted = "never" if math.isinf(predicted) else f"at {predicted:.4g} s"
            yield f"an error of {level:.0%} at {measured:.4g} s, predicted {wanted}"
