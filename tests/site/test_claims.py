"""Findings say what the stored study shows: another stored figure, another page; and what the
figures do not show is not claimed."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.study.gradient import Gradients
from plumbob.engines.study.identification import Identification
from plumbob.engines.study.long_runs import MeasuredLongRun
from plumbob.engines.study.model_reading import ModelRead
from plumbob.engines.study.stability import SceneLimits
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import systems
from plumbob.reports.analyses import section
from plumbob.reports.analyses.claims import CLEAR_RATIO, at_most, between, clearly_larger
from plumbob.reports.records.page_records import ENGINES_SECTION
from plumbob.reports.view.site.claims import NOT_SHOWN, checked_findings
from plumbob.tests.site import whole_profile
from plumbob.tests.support.declared import findings_of
from plumbob.tests.support.studies import remeasured

COMPUTED = (  # from the sources and the exact motions alone: no figure of theirs is measured
    "capsule-mean-speed",
    "capsule-plan-legs",
    "capsule-tipping",
    "capsule-heights",
    "special-functions",
    "capsule-experiment",
    "capsule-plan-poses",
    "capsule-turn-second-order",
    "capsule-turn-course",
    "capsule-turn-left-over",
    "capsule-turn-touch",
    "capsule-turn-source",
    "claims",
    "source-text",
    "uniformity",
    "equilibria",
    "notebook-claims",
    "notebook-bob",
    "cheetah-rhythm",
    "trained-policies",
    "cart-pole-loop",
)
MEASURED = (
    "capsule-misprints",
    "capsule-any-line",
    "capsule-line-source",
    "capsule-displacement",
    "capsule-contact-chatter",
    "capsule-isotropy",
    "capsule-identified-friction",
    "capsule-loads",
    "capsule-driving-force",
    "capsule-momentum",
    "capsule-plan-open-loop",
    "capsule-train-total",
    "printed-hamiltonian",
    "inertia-y",
    "no-symmetry",
    "action-phase",
    "drive-work",
    "generating-solution",
    "bouncing-ball-restitution",
    "gradients",
    "gradients-through-contact",
    "errors-and-costs",
    "largest-steps",
    "long-runs",
    "model-readers",
    "notebook-rk4",
    "held-control",
)
UNITED = 0.5  # every error of a spoiled study, at every step
FAR = 0.7  # by how much its recordings depart by their end, in SI


@pytest.fixture(scope="module")
def spoiled(study):
    """The study with the same large error in every run and recording, and other costs."""

    def wrong(m):
        return replace(
            m, errors={n: replace(e, largest=UNITED, end=UNITED) for n, e in m.errors.items()}
        )

    return replace(
        remeasured(study, wrong),
        costs={
            pair: replace(cost, ns_per_step=cost.ns_per_step * (1.0 + 0.1 * (place % 7)))
            for place, (pair, cost) in enumerate(study.costs.items())
        },
        extras={request: _far(found) for request, found in study.extras.items()},
    )


def _far(found):
    """A recording that departs from where it was, ever faster, with energies of its own; and a
    reading of a model that has no number but its gravity, and another predicted step."""
    if isinstance(found, ModelRead):
        rest = ((f, n, v if f == "gravity" else (0.0,)) for f, n, v in found.numbers)
        return replace(found, numbers=tuple(rest))
    if isinstance(found, SceneLimits):
        return replace(found, limits=tuple(replace(x, predicted=1.0) for x in found.limits))
    if isinstance(found, Identification):
        fits = (replace(fit, identified=2.0 * fit.identified) for fit in found.parameters)
        return replace(found, parameters=tuple(fits))
    if isinstance(found, Gradients):
        tried = [(replace(of.tried[0], computed=3.0 * of.exact),) for of in found.records]
        return Gradients(tuple(map(lambda of, t: replace(of, tried=t), found.records, tried)))
    if isinstance(found, MeasuredLongRun):
        return replace(found, times={level: 3.0 * time for level, time in found.times.items()})
    if not isinstance(found, Trajectory):
        return found
    gone = FAR * (found.times / found.times[-1]) ** 2
    seen = {name: values + gone for name, values in found.observables.items()}
    energies = {"kinetic": gone, "potential": gone, "platform_rate": 1.0 + gone}
    channels = {name: np.asarray(values) + gone for name, values in found.channels.items()}
    return replace(found, observables=seen, channels=channels | energies)


def _findings(study):
    own = [one for name in (*systems(), ENGINES_SECTION) if (one := section(name)) is not None]
    return {f.name: f for one in own for f in findings_of(one, study)}


@pytest.fixture(scope="module")
def before():
    return {finding.name: finding for finding in whole_profile.findings()}


@pytest.fixture(scope="module")
def after(spoiled):
    return _findings(spoiled)


@pytest.mark.long
def test_every_finding_is_named_here(before):
    assert set(before) == {*COMPUTED, *MEASURED}


@pytest.mark.long
def test_another_figure_in_the_store_is_another_on_the_page(before, after):
    said = {name: [replace(of[name], claims=()) for of in (before, after)] for name in MEASURED}
    assert [name for name, (first, other) in said.items() if first == other] == []


@pytest.mark.long
def test_what_is_computed_stays(before, after):
    assert [name for name in COMPUTED if before[name].summary != after[name].summary] == []
    # heights are a difference of recordings that are spoiled alike; swings were not invented
    claimed = [name for name in COMPUTED if before[name].claims != ()]
    assert claimed == ["capsule-heights", "equilibria"]


def _claiming(*found):
    for name in MEASURED:
        if any(one[name].claims for one in found):
            yield name


@pytest.mark.long
def test_what_is_not_shown_is_not_claimed(before, after):
    """In one or the other of two studies whose contacts all do alike, whose recordings depart, each
    finding that rests on a figure is no longer claimed."""
    shown = {
        f.name: f
        for both in (before, after)
        for f in checked_findings(both.values())
        if f.judgement == NOT_SHOWN
    }
    assert set(_claiming(before, after)) - set(shown) == set()
    for name, left in shown.items():
        words, title = left.title.partition(": ")[::2]
        assert words == "Not shown by this study"
        # a figure may be in the rest
        assert title.split()[:6] == before[name].title.split()[:6]
        assert left.statements == ()
        assert any(char.isdigit() for char in left.summary)


@pytest.mark.parametrize(
    ("holding", "failing"),
    [
        (at_most("x", -1.0, 1.0), at_most("x", -1.01, 1.0)),
        (at_most("x", 0.0, 1.0), at_most("x", float("nan"), 1.0)),
        (clearly_larger("x", -CLEAR_RATIO, 1.0), clearly_larger("x", 0.99 * CLEAR_RATIO, 1.0)),
        (clearly_larger("x", 1.0, 0.0), clearly_larger("x", 0.0, 0.0)),
        (between("x", 1.0, 1.0, 2.0), between("x", 2.01, 1.0, 2.0)),
    ],
)
def test_claims_are_held_from_both_sides(holding, failing):
    assert holding.holds
    assert not failing.holds
