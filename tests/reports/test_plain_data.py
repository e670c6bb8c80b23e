"""Numbers and records as plain data: one function, in the form for templates or for JSON."""

import math
from dataclasses import dataclass
from types import MappingProxyType, SimpleNamespace

import numpy as np
import pytest

from plumbob.reports.records.page_records import SCENE, records_of
from plumbob.reports.records.plain_data import FOR_JSON, FOR_TEMPLATES, plain
from plumbob.tests.support.studies import quick


@dataclass(frozen=True)
class Length:
    """A length with a property."""

    metres: float

    @property
    def doubled(self):
        return 2 * self.metres


@pytest.mark.parametrize(
    ("value", "for_templates", "for_json"),
    [
        (Length(1.0), {"metres": 1.0, "doubled": 2.0}, {"metres": 1.0}),
        (SimpleNamespace(a=(1, "b")), {"a": (1, "b")}, {"a": [1, "b"]}),
        (MappingProxyType({1: np.float64(0.5)}), {"1": 0.5}, {"1": 0.5}),
        (np.array([[1, 2], [3, 4]]), ((1, 2), (3, 4)), [[1, 2], [3, 4]]),
        (
            [-math.inf, np.inf, None, True],
            (-math.inf, math.inf, None, True),
            [None, None, None, True],
        ),
    ],
)
def test_each_form_has_its_sequences_and_numbers(value, for_templates, for_json):
    assert plain(value, FOR_TEMPLATES) == for_templates
    assert plain(value, FOR_JSON) == for_json
    assert type(plain(np.int64(3), FOR_JSON)) is int


def test_a_page_takes_the_records_of_its_own_process():
    study = quick()
    made = {a.scene: a.numbers for a in study.analyses if a.place == SCENE}
    scenes = records_of(study).scenes
    assert scenes
    assert all(scenes[name] is made[name] for name in scenes)
