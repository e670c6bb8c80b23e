"""The section on the simple pendulum: the notebook's cases, and a held control."""

from __future__ import annotations

from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.simple_pendulum.bob import BOB
from plumbob.reports.analyses.simple_pendulum.claims import NOTEBOOK_CLAIMS
from plumbob.reports.analyses.simple_pendulum.notebook import CASE_MOTIONS, NOTEBOOK_RK4
from plumbob.reports.analyses.simple_pendulum.orders import HELD_CONTROL

SIMPLE_PENDULUM_FINDINGS = (
    NOTEBOOK_CLAIMS,
    BOB,
    NOTEBOOK_RK4,
    HELD_CONTROL,
)
SECTION = Section(SIMPLE_PENDULUM_FINDINGS, (CASE_MOTIONS,))
