"""The list of mutations can be run: each line is in its file once, and its tests are there."""

from collections import Counter

import pytest

from plumbob.tests.validation.mutations import ROOT, mutations

EVERY = mutations()


@pytest.mark.parametrize("one", EVERY, ids=lambda m: m.name)
def test_a_mutation_applies(one):
    assert one.file.partition("/")[0] == one.layer
    assert (ROOT / one.file).read_text("utf-8").count(one.line) == 1
    assert one.becomes != one.line
    assert one.tests
    for word in one.tests.split():
        path, _, test = word.partition("::")
        if path.startswith("tests/"):
            assert (ROOT / path).exists()
            assert not test or f"def {test.partition('[')[0]}(" in (ROOT / path).read_text(
                "utf-8"
            )


def test_names_are_unique_and_few_survive():
    assert not [name for name, count in Counter(m.name for m in EVERY).items() if count > 1]
    assert sum(bool(m.survives) for m in EVERY) <= 0.05 * len(EVERY)
