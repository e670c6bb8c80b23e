"""Derivatives through contact: converging, noise, or smooth and wrong."""

import numpy as np
import pytest

from plumbob.reports.analyses.engines.through_contact import (
    CONTACT_CURVES,
    SLIDING_SCENE,
    THROUGH_CONTACT,
)
from plumbob.tests.support.declared import measured, numbers_of


@pytest.mark.long
def test_default_contacts_are_wrong_and_noise_where_recommended_ones_converge():
    found = numbers_of(THROUGH_CONTACT, measured(SLIDING_SCENE, CONTACT_CURVES))
    default, recommended = found.nearby
    assert (default.kind, recommended.kind) == ("noise", "converges")
    assert default.exact == pytest.approx(0.0196745 * 0.3 / 0.0055917, rel=1e-5)
    assert np.array(default.errors) / default.exact == pytest.approx(-0.49, abs=0.02)
    assert default.scatter[1] > 0.2
    assert np.abs(recommended.errors).max() < 5e-3
    (_, at, slope) = found.tangents["exact"][1]
    assert at == pytest.approx(-0.0055917, rel=1e-6)
    # by differences, h^2 over the friction's
    assert slope == pytest.approx(0.0196745, rel=1e-3)
    for name, (_, _, (_, _, last)) in found.tangents.items():
        assert (last == pytest.approx(0.01776, rel=0.02)) == (name != CONTACT_CURVES[0])
