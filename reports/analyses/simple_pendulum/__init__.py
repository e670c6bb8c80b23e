"""The section on the simple pendulum: the notebook's cases, and a held control."""

from __future__ import annotations

from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.simple_pendulum.bob import BOB
from plumbob.reports.analyses.simple_pendulum.claims import CLAIMS
from plumbob.reports.analyses.simple_pendulum.notebook import CASE_MOTIONS, RK4
from plumbob.reports.analyses.simple_pendulum.orders import HELD_CONTROL

FINDINGS = (
    CLAIMS,
    BOB,
    RK4,
    HELD_CONTROL,
)
SECTION = Section(FINDINGS, (CASE_MOTIONS,))
