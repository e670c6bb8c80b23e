"""The section on plans that bring the capsule to a pose: poses reached, and open-loop runs."""

from __future__ import annotations

from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.capsule_plan.legs import LEGS
from plumbob.reports.analyses.capsule_plan.open_loop import OPEN_LOOP
from plumbob.reports.analyses.capsule_plan.poses import POSES

SECTION = Section((POSES, LEGS, OPEN_LOOP))
