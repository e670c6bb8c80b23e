"""The choice that leads the index: what a reader simulates, and the settings for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plumbob.engines.study.results import Study
from plumbob.reports.advice.simulated_kinds import (
    CHOSEN_ERRORS,
    CHOSEN_STEPS,
    AdvisedKind,
    AdvisedSetting,
    KindAdvice,
    advised_kinds,
)
from plumbob.reports.records.page_records import Records, advised_name
from plumbob.reports.view.site.views import PageView

FIRST_CHOICE = (None, 0.01)  # chosen at first: any step (None), and a wanted error of 0.01
CHOSEN_FRICTION = 0.3  # friction coefficient in the settings, until a reader changes it


def simulated_kinds(study: Study, records: Records) -> Sequence[PageView]:
    """Returns a view for each kind of body that the study gives advice for."""
    verdicts = {
        (scene, method): judged.verdict
        for scene, record in records.scenes.items()
        for method, judged in record.verdicts.items()
    }
    kinds = advised_kinds(study, verdicts)
    return [_kind_view(kind, records.study.advised) for kind in kinds]


def chooser_options() -> PageView:
    """Returns the choices of a reader: steps and wanted errors, each with its name in an address,
    and the friction at first."""
    return PageView(
        steps=[(choice_name(step), step) for step in CHOSEN_STEPS],
        errors=[(choice_name(error), error) for error in CHOSEN_ERRORS],
        first=tuple(map(choice_name, FIRST_CHOICE)),
        friction=CHOSEN_FRICTION,
    )


def choice_name(chosen: float | None) -> str:
    """Returns the name of a step [s] or of an error in an address."""
    return "any" if chosen is None else f"{chosen:g}"


def _kind_view(kind: AdvisedKind, snippets: Mapping[str, str]) -> PageView:
    """Returns the view of one kind; choices with the same advice share one answer."""
    grouped: dict[object, list[KindAdvice]] = {}
    for one in kind.advice:
        same = (one.setting, one.reached, one.elsewhere, one.further)
        grouped.setdefault(same, []).append(one)
    answers = sorted(map(_answer, grouped.values()), key=lambda answer: not answer.first)
    copied = dict.fromkeys(answer.copied for answer in answers if answer.copied)
    return PageView(
        name=kind.name,
        scenes=[scene.name for scene in kind.scenes],
        frictions=sorted(
            {
                float(scene.parameters["friction"])
                for scene in kind.scenes
                if "friction" in scene.parameters
            }
        ),
        hard=len(kind.hard),
        defaults=kind.defaults,
        answers=answers,  # the one for `FIRST_CHOICE` comes first
        # what to copy for each setting, those of the first answer first
        copies=[(setting, _advised_snippet(setting, snippets)) for setting in copied],
    )


def _answer(group: Sequence[KindAdvice]) -> PageView:
    """Returns the view of the advice that several choices share."""
    one = group[0]
    choices = [(choice.step, choice.error) for choice in group]
    return PageView(
        choices=choices,
        names=" ".join(f"{choice_name(step)}:{choice_name(error)}" for step, error in choices),
        first=FIRST_CHOICE in choices,
        setting=one.setting,
        reached=one.reached,
        elsewhere=one.elsewhere,
        further=one.further,
        copied=one.setting or one.elsewhere,
    )


def _advised_snippet(setting: AdvisedSetting, snippets: Mapping[str, str]) -> str:
    """Returns the MJCF of a setting; empty if a study of an older version lacks it."""
    return snippets.get(advised_name(setting.method, setting.step), "")
