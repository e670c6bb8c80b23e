"""Derivatives in tests: the scale of their errors, and the judgement on one of them."""

import numpy as np

from plumbob.engines.registry import method
from plumbob.engines.study.gradient import GradientSearch
from plumbob.reports.judge.gradients import judged_gradients


def scaled(values, observed, number):
    """Its own size, or the observable's over the parameter's, the larger."""
    largest = max(
        float(np.abs(values).max()), float(np.abs(observed).max() / (abs(number) or 1))
    )
    return largest or 1.0


def judgements(search):
    """The judgements on the derivatives of a search."""
    return list(judged_gradients(search, search.answer(method(search.method))))


def judged_way(name, how, of, by, way, step=None, at=None):
    """The judgement on the derivative that one way gives of an observable `of` by a parameter."""
    (judged,) = judgements(GradientSearch(name, how, (of,), by, (way,), step, at=at))
    return judged
