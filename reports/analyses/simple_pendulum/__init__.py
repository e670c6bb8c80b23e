"""The page's section on the simple pendulum: the notebook's cases, orders, energy, references."""

from __future__ import annotations

from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.simple_pendulum.bob import BOB
from plumbob.reports.analyses.simple_pendulum.claims import CLAIMS
from plumbob.reports.analyses.simple_pendulum.energy import ENERGY, MILLION_STEPS
from plumbob.reports.analyses.simple_pendulum.exactness import NEAR_TOP, REFERENCES, TOP_GROWTH
from plumbob.reports.analyses.simple_pendulum.notebook import CASE_MOTIONS, RK4
from plumbob.reports.analyses.simple_pendulum.orders import HELD_CONTROL, ORDERS
from plumbob.reports.analyses.simple_pendulum.tension import TENSION

FINDINGS = (
    CLAIMS,
    BOB,
    RK4,
    ORDERS,
    HELD_CONTROL,
    ENERGY,
    TENSION,
    REFERENCES,
    NEAR_TOP,
)
SECTION = Section(FINDINGS, galleries=(CASE_MOTIONS,), hard=(TOP_GROWTH, MILLION_STEPS))
