"""Results of audits as Python and notebooks show them: a line, text, a card, plain data, a plot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.contacts import ContactAudit
from plumbob.reports.view.audit.page import answer_lines, answer_rows, audit_answer, card_lines
from plumbob.reports.view.audit.records import record
from plumbob.reports.view.page import fill_page


class _Shown:
    """The ways in which both kinds of audits are shown."""

    @property
    def _audit(self) -> Audit | ContactAudit:
        assert isinstance(self, (Audit, ContactAudit))
        return self

    def __repr__(self) -> str:
        return f"<audit of {Path(self._audit.name).name}: {self._card()[0]}>"

    def _card(self) -> list[str]:
        """The answer in a line, then lines of MJCF that a file needs for a smaller error."""
        audit = self._audit
        if isinstance(audit, Audit):
            return card_lines(audit)
        answer = dict(answer_rows(audit_answer(audit)))
        return [
            answer["your contacts" if audit.own else "not run"],
            *audit.snippet.splitlines(),
        ]

    def _repr_html_(self) -> str:
        answer = audit_answer(self._audit)
        return fill_page(
            "audit_card.html.jinja",
            shared="",
            card=self._card(),
            rows=answer_rows(answer),
            finding=answer,
        )

    def text(self) -> str:
        """The answer as `plumbob audit` prints it."""
        return "\n".join(answer_lines(audit_answer(self._audit)))

    def to_dict(self) -> dict[str, Any]:
        """The answer as `plumbob audit --json` prints it: numbers in SI units, arrays as lists, and
        None for a number that is not finite."""
        return record(self._audit)

    def plot(self, title: str = "") -> Any:
        """The figure of the audit's page that has this `title`, or the first, the error over time,
        or by heading, as a `plotly.graph_objects.Figure`. Raises ParameterError where there is
        none, naming those that there are."""
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

    `error` [m] is the largest displacement of any corner of a body's geoms from where the certified
    motion has it, over the motion up to `until` [s], at the model's own `integrator` and `step`
    [s]: the corners of the geoms' boxes, or of the box of its inertia where it has none, so that
    rotation counts. `state_errors.attitude` [rad], `state_errors.coordinates` [rad or m] and
    `state_errors.activations` are the largest errors of these. `uncertainty` [m] is how well that
    motion is known. `resolved`, `complete` and `still` say whether the error stands out of that, is
    known to the end, and nothing moves. `pose` has the centre of mass [m], shape (3,), of each body
    at `until`, and `corners` the corners [m], shape (n, 3), of each that can move.

    `script` has the start, shape (n,), and the controls, shape (periods, actuators);
    `reference.corners` [m], shape (periods + 1, corners, 3), of the bodies `model.corner_bodies`,
    is the certified motion at `script.times` [s], shape (periods + 1,), known to
    `reference.uncertainty` [m] of that shape. `found.own.errors` [m], of that shape, are the errors
    so far of the own step, and `found.steps` the same of all runs; `found` is None where there is
    no reference, as `reference.why` says.
    `stability` has the largest steps [s] that hold, `trims` what can be left out, `gradient` the
    derivatives, and `seconds` the wall time. `assert_within(metres)`, `assert_referenced()` and
    `assert_stable()` raise AssertionError.
    """


class ContactResult(_Shown, ContactAudit):
    """The answer of `plumbob.audit_contacts`.

    `exact` [m] is the stopping distance from `speed` [m/s] by Coulomb's law, None where that does
    not determine it, as `why` says. `own` and `pasted` are runs at the model's `step` [s] and its
    halvings, with the model's contacts and with those of `snippet`: each has `step` [s],
    `distances` [m] by heading, shape (headings,), `drift` [m/s] and `turning`. `error(run)` [m] is
    the largest error of a run, `errors(run)` [m] those by heading, relative to `distances` [m],
    which are known to `known` [m]. `assert_within(metres)` raises AssertionError.
    """
