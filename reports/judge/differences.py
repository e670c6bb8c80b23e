"""The verdict on recorded motions: whether rounding and the solver explain what differs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from plumbob.engines.difference.sample_steps import StepLaw

if TYPE_CHECKING:  # records that need the theory of the band
    from plumbob.engines.difference.difference import ComparedMotions

DifferenceVerdict = Literal[
    "same bits", "explained", "explained so far", "other steps", "other start", "beyond", "open"
]
EXPLAINED = ("same bits", "explained", "explained so far")


def difference_verdict(compared: ComparedMotions) -> DifferenceVerdict:
    """Returns the verdict on one or two recordings:

    - "other steps": a step is not the model's, or all are taken by another law;
    - "open": the time ended before all steps were checked;
    - "other start": the recordings differ at their first common sample;
    - "beyond": their difference exceeds the band;
    - "same bits": nothing differs;
    - "explained so far": the difference is within the band, which ends before the recordings do;
    - "explained": all steps are the model's, and the difference is within the band."""
    for steps in compared.steps:
        if steps.findings or not is_own_law(compared, steps.law):
            return "other steps"
    difference = compared.difference
    if any(
        steps.checked < len(recording.times) - 1
        for steps, recording in zip(compared.steps, compared.recordings, strict=True)
    ):
        return "open"
    if difference is None:
        return "explained"
    if difference.at_start:
        return "other start"
    if (difference.uses > 1.0).any():
        return "beyond"
    if difference.first is None:
        return "same bits"
    return "explained so far" if difference.why else "explained"


def is_own_law(compared: ComparedMotions, law: StepLaw) -> bool:
    """Returns whether a law of steps is the model's own."""
    return law == StepLaw(compared.model.integrator, compared.model.step)
