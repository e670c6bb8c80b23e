"""Audits of these tests time steps for a fifth as long: what they advise depends on it by less than
what they take for alike."""

import pytest

from plumbob.engines.audit import costs


@pytest.fixture(autouse=True, scope="module")
def _brief():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(costs, "PIECE", costs.PIECE / 5.0)
        yield
