"""Results of audits for Python and notebooks: as a line, text, a card, plain data or a plot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.contacts import ContactAudit
from plumbob.engines.audit.holds import HoldsAudit
from plumbob.engines.difference.repetitions import RepeatedMotion
from plumbob.reports.advice.fixed_file import FIXED_SECONDS, FixedFile, write_fixed_file
from plumbob.reports.view.audit.page import (
    AnyAudit,
    answer_lines,
    answer_rows,
    audit_answer,
    card_lines,
    code_to_paste,
)
from plumbob.reports.view.audit.records import record
from plumbob.reports.view.page import fill_page


class _Shown:
    """Methods that show an audit, for all kinds of audits."""

    @property
    def _audit(self) -> AnyAudit:
        """The instance as the audit that a subclass makes it."""
        assert isinstance(self, (Audit, ContactAudit, HoldsAudit, RepeatedMotion))
        return self

    def __repr__(self) -> str:
        return f"<audit of {Path(self._audit.name).name}: {self._card()[0]}>"

    def _card(self) -> list[str]:
        """Returns the answer as a line, followed by the lines of MJCF that reduce the error."""
        audit = self._audit
        if isinstance(audit, Audit):
            return card_lines(audit)
        answer = dict(answer_rows(audit_answer(audit)))
        if isinstance(audit, RepeatedMotion):
            return [answer["answer"]]
        if isinstance(audit, HoldsAudit):
            first = "Coulomb"
        else:
            first = "your contacts" if audit.own else "not run"
        return [answer[first], *code_to_paste(audit).splitlines()]

    def _repr_html_(self) -> str:
        """Returns the card of the audit as HTML, for a notebook."""
        answer = audit_answer(self._audit)
        return fill_page(
            "audit_card.html.jinja",
            shared="",
            card=self._card(),
            rows=answer_rows(answer),
            finding=answer,
        )

    def text(self) -> str:
        """Returns the answer as `plumbob audit --verbose` prints it."""
        return "\n".join(answer_lines(audit_answer(self._audit)))

    def to_dict(self) -> dict[str, Any]:
        """Returns the answer as `plumbob audit --json` prints it: numbers in SI units, arrays as
        lists, and None for a number that is not finite."""
        return record(self._audit)

    def plot(self, title: str = "") -> Any:
        """Returns the figure of the audit's page with this `title`, as a
        `plotly.graph_objects.Figure`. By default it is the first figure: the error over time, or by
        heading. Raises ParameterError, naming the figures, if no figure has the title."""
        from plotly.graph_objects import Figure

        figures = {figure.title: figure for figure in audit_answer(self._audit).figures}
        title = title or next(iter(figures), "")
        if title not in figures:
            names = ", ".join(figures) or "none"
            raise ParameterError("title", title, f"a figure of this audit: {names}")
        chosen = figures[title]
        return Figure(list(chosen.traces), {**chosen.layout, "title": {"text": title}})


class MotionResult(_Shown, Audit):
    """The answer of `plumbob.audit`.

    `error` [m] is the error of the model's `integrator` and `step` [s]: the largest displacement of
    any corner from the certified motion, at any time up to `until` [s]. The corners are those of
    the boxes around a body's geoms, or of the box of its inertia if it has no geoms, so that
    rotation counts. `state_errors.attitude` [rad], `state_errors.coordinates` [rad or m] and
    `state_errors.activations` are the largest errors of the state. `uncertainty` [m] bounds the
    error of the certified motion. `resolved` says whether the error exceeds this uncertainty,
    `complete` whether it is known to the end of the motion, and `still` whether nothing moves.
    `pose` holds each body's centre of mass at `until` [m], shape (3,), and `corners` the corners of
    each movable body [m], shape (n, 3).

    `script` holds the start, shape (n,), and the controls, shape (periods, actuators). The
    certified motion is `reference.corners` [m], shape (periods + 1, corners, 3), of the bodies
    `model.corner_bodies`, at `script.times` [s], shape (periods + 1,); `reference.uncertainty` [m]
    has the shape of the times. `found.own.errors` [m], also of this shape, are the largest errors
    so far of the model's step, and `found.steps` are the errors of all runs. `found` is None if no
    motion is certified; `reference.why` is the reason.

    `stability` holds the largest stable steps [s], `trims` the features that can be left out,
    `gradient` the derivatives, and `seconds` the wall time. `assert_within(metres)`,
    `assert_referenced()` and `assert_stable()` raise AssertionError. `write_fixed(path)` writes the
    advice into a copy of the model file.
    """

    def write_fixed(self, path: str | Path, budget: float = FIXED_SECONDS) -> FixedFile:
        """Writes the advised integrator and step into the text of the model file, as the new file
        `path`, and audits the new file on the same motion, in about `budget` [s] of processor time.

        Returns the new file's `error` [m], the `promised` one and their `uncertainty` [m], `kept`,
        and the whole `audit`. Raises NothingToFix, a ValueError, if the advice is to keep the step,
        and ParameterError if the model was no file, or `path` exists or cannot be written."""
        return write_fixed_file(self, Path(path), positive("budget", budget))


class ContactResult(_Shown, ContactAudit):
    """The answer of `plumbob.audit_contacts`.

    `exact` [m] is the stopping distance from `speed` [m/s] by Coulomb's law. It is None if the law
    does not determine the distance; `why` is the reason. `own` are the runs with the model's
    contacts and `pasted` the runs with the contacts of `snippet`, at the model's `step` [s] and its
    halves. A run has `step` [s], `distances` [m] by heading, shape (headings,), `drift` [m/s] and
    `turning`. `errors(run)` [m] are the errors of a run by heading, against `distances` [m], which
    are known to `known` [m]; `error(run)` [m] is the largest of them. `assert_within(metres)`
    raises AssertionError."""


class RepeatedResult(_Shown, RepeatedMotion):
    """The answer of `plumbob.audit_reproducible`.

    `repetitions` holds a row for each way in which the motion was computed again: its `verdict`
    ("same bits", "within", "beyond", "open" or "not run"), the `factor` by which its largest
    difference uses what rounding and the solver allow, the time `begin` [s] from which on it is
    beyond, and the difference at the `end` [m or rad]. `difference` has the growth of the
    difference beside the band, and `steps` what single steps differ by. `beyond` and `open` are the
    rows with these verdicts. `assert_reproducible()` raises AssertionError if a row is beyond."""


class HoldsResult(_Shown, HoldsAudit):
    """The answer of `audit_holds`.

    `coulomb` is what Coulomb's law says about the bodies at rest: "holds", "can hold with a
    preload", "too close to tell" or "cannot hold"; `groups` has the verdict on each group of
    connected bodies, with its `statics`. `creep` is measured, `predicted` [m/s] is the prediction,
    and `remedy` the options that stop the creep, or None. `assert_holds()` and
    `assert_creeps_within(speed)` raise AssertionError."""
