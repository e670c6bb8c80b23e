"""A model file with the advice of its audit written into it, and the audit of that file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.audit import Audit, audited
from plumbob.engines.audit.step_errors import StepError
from plumbob.engines.audit.user_models import quiet, user_models
from plumbob.engines.own_motion import FileFix, FixPlace
from plumbob.reports.advice.audit_advice import AuditAdvice, StepChoice, audit_advice

NAME = "write fixed"
FIXED_SECONDS = 60.0  # [s] default processor time of the audit of the new file
COMPILED = (
    "left out, or the model a file of MJCF or URDF: a compiled model has no text to change"
)
NEW_FILE = "a file that does not exist yet, in a folder that can be written to"


class NothingToFix(ValueError):
    """The advice of an audit has nothing to write into the model file; the text says why."""


@dataclass(frozen=True)
class FixedFile:
    """A new model file that has the advised integrator and step, and its audit on the same motion.

    The errors are compared at the last time up to which both audits know them."""

    path: Path
    place: FixPlace
    choice: StepChoice
    audit: Audit  # the new file's audit
    until: float  # [s] time up to which the errors below are taken
    before: float  # [m] error of the file as it was
    # [m] error that the audit of the file as it was found at the new file's integrator and step
    promised: float
    error: float  # [m] error that the audit of the new file found; NaN if it has no reference
    uncertainty: float  # [m] sum of the uncertainties of the certified motions of both audits

    @property
    def kept(self) -> bool:
        """Whether the error of the new file is the promised one, within the uncertainty."""
        return abs(self.error - self.promised) <= self.uncertainty


def check_fixable(source: Path | None, target: Path) -> None:
    """Raises ParameterError if the model has no text, or if the new file `target` exists, has
    another ending than the model's file, or cannot be written."""
    if source is None or source.suffix == ".mjb":
        raise ParameterError(NAME, str(target), COMPILED)
    check_new_file(NAME, target, source.suffix)


def check_new_file(name: str, target: Path, suffix: str) -> None:
    """Raises ParameterError, naming the option `name`, if the file `target` exists, does not end
    with `suffix`, or cannot be written."""
    expected = f"{NEW_FILE}, with the ending {suffix}"
    if target.suffix != suffix:
        raise ParameterError(name, str(target), expected)
    try:
        target.touch(exist_ok=False)
        target.unlink()
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise ParameterError(name, str(target), f"{expected} ({reason})") from None


@quiet()
def write_fixed_file(
    audit: Audit,
    target: Path,
    seconds: float,
    progress: Callable[[str], None] = lambda what: None,
) -> FixedFile:
    """Writes the advice of an audit into a copy of the model file, reads the new file and audits it
    on the same motion, in about `seconds` of processor time. Raises NothingToFix if the advice
    keeps the step, and ParameterError if the file cannot be written."""
    source = audit.model.file
    check_fixable(source, target)
    assert source is not None
    advice = audit_advice(audit)
    choice = _choice_to_write(advice)
    if choice is None:
        raise NothingToFix(_reason(audit, advice))
    options = choice.new_options
    # Time constants are raised for another step; the step itself does not need them.
    raised = advice.raised if "timestep" in options else ()
    fix = FileFix(options, choice.unguarded, raised, advice.raised_to)
    place = user_models().write_fixed(source, fix, target)
    model = user_models().model(target, audit.model.begin)
    allowance = Allowance(seconds, progress=progress)
    return _compared_audits(
        audit, choice, place, target, audited(model, audit.script, audit.control, allowance)
    )


def _choice_to_write(advice: AuditAdvice) -> StepChoice | None:
    """Returns the integrator and step that the advice names first; None if it names none, or only
    the model's own."""
    choice = advice.better or advice.enough
    return choice if choice is not None and choice.options else None


def _reason(audit: Audit, advice: AuditAdvice) -> str:
    """Returns the reason why there is no integrator and step to write."""
    if advice.situation == "uncertified":
        return "no motion of the model is certified"
    if advice.situation == "still":
        return "nothing moves on this motion"
    if advice.accurate and not advice.near_limit:
        return f"the advice is to keep {audit.integrator} at {audit.step:g} s"
    return "no integrator and step that was run is reliably nearer"


def _compared_audits(
    audit: Audit, choice: StepChoice, place: FixPlace, target: Path, after: Audit
) -> FixedFile:
    """Returns the record of a new file with its audit `after`."""
    assert audit.found is not None
    index = audit.found.index
    error = uncertainty = float("nan")
    if after.found is not None:
        index = min(index, after.found.index)
        error = after.found.own.at(index)
        uncertainty = float(after.reference.uncertainty[index])
    return FixedFile(
        path=target,
        place=place,
        choice=choice,
        audit=after,
        until=float(audit.script.times[index]),
        before=audit.found.own.at(index),
        promised=_run_of(audit, choice).at(index),
        error=error,
        uncertainty=uncertainty + float(audit.reference.uncertainty[index]),
    )


def _run_of(audit: Audit, choice: StepChoice) -> StepError:
    """Returns the run of an audit that a choice advises."""
    assert audit.found is not None
    chosen = choice.integrator, choice.step
    return next(run for run in audit.found.steps if (run.integrator, run.step) == chosen)
