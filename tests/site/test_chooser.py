"""The choice that leads the index: its numbers from the stored runs, by other code; its settings as
the command prints them; and the page in Chromium, by address, and without JavaScript."""

import html
import re
from statistics import median_high

import pytest

from plumbob.engines.study.extra_runs import StepRun
from plumbob.engines.study.stability import StabilitySearch
from plumbob.reports.cli import main
from plumbob.reports.records import notation
from plumbob.reports.view.site.writing import write_study_pages
from plumbob.tests.site import chosen
from plumbob.tests.site.test_reach import DESK, PHONE, SMALL, _faults
from plumbob.tests.support.browser import visited
from plumbob.tests.support.page_document import Document, broken_links, resolve, site_files

# usual scenes of each kind in the study, as a reader would name them
SCENES = {
    "slides": ("capsule-line/ca1", "capsule-coast/translation"),
    "arm": ("servo/motor-damped", "servo/joint-damped", "linear-pendulum/overdamped"),
    "servo": ("servo/motor-damped", "servo/joint-damped"),
    "grips": ("pinch/0.5", "incline/rest"),
    "rolls": ("rolling-ball/slide-to-roll",),
}
NAMED = re.compile(r"<code>(mujoco/\S+)</code> at (\S+)&nbsp;ms")
USE = re.compile(r'<p class="use">.*?</p>', re.S)
KEPT = re.compile(r"error <b>(.*?)</b>", re.S)
SEEN = """() => [...document.querySelectorAll("#simulate .kind")]
  .filter((one) => one.checkVisibility()).map((one) => [one.dataset.kind, one.innerText])"""


@pytest.fixture(scope="module")
def index(tmp_path_factory):
    return write_study_pages(chosen.study(), tmp_path_factory.mktemp("chosen"))


@pytest.fixture(scope="module")
def text(index):
    return index.read_text("utf-8")


def _articles(text):
    """The HTML of each kind's article."""
    return dict(re.findall(r'<article class="kind" id="kind-(\w+)"(.*?)</article>', text, re.S))


def _plain(markup):
    return " ".join(html.unescape(re.sub(r"<[^>]+>", "", markup)).split())


def _error(scene, method, step):
    """The largest error at a step and at all smaller ones, from the stored runs; the run at the
    next larger step counts where there is none. None if there is no such run."""
    study = chosen.study()
    runs = {
        m.step: m
        for c in study.convergence
        for m in c.measurements
        if (m.scene, m.method) == (scene, method)
    }
    more = study.extras.get(StepRun(scene, method, 0.002))
    if more:
        runs[0.002] = more
    largest = min((h for h in runs if h > 0.999999 * step), default=None)
    if largest is None:
        return None
    return max(chosen.error_of(run) for h, run in runs.items() if h <= largest)


def _cost(kind, method, step):
    """The computing time [ns] of a simulated second."""
    return (
        median_high(chosen.study().costs[scene, method].ns_per_step for scene in SCENES[kind])
        / step
    )


def test_the_kinds_of_the_study_and_ones_own_file(text):
    assert set(_articles(text)) == {*SCENES, "own"}
    assert "plumbob audit my.xml" in _articles(text)["own"]


@pytest.mark.parametrize("kind", SCENES)
def test_every_error_and_cost_follows_from_the_stored_runs(kind, text):
    blocks = re.findall(
        r'<div class="advice" data-for="(.*?)".*?>(.*?)</div>', _articles(text)[kind], re.S
    )
    choices = [choice for names, _ in blocks for choice in names.split()]
    assert len(choices) == len(set(choices)) == 15
    for _, block in blocks:
        (use,) = USE.findall(block)
        method, ms = NAMED.search(use).groups()
        step = 1e-3 * float(ms)
        error = max(_error(scene, method, step) for scene in SCENES[kind])
        assert _plain(KEPT.search(use)[1]) == notation.relative(error).replace("\u00a0", " ")
        cost = _cost(kind, method, step)
        said = _plain(block)
        assert f"{notation.number(1e-6 * cost, 2)} ms of computing" in said
        default = _cost(kind, "mujoco/euler", 0.002)
        assert f"{notation.number(cost / default, 2)} times the default's" in said


@pytest.mark.parametrize("kind", SCENES)
def test_the_default_errors_are_those_of_the_stored_runs(kind, text):
    errors = []
    for scene in SCENES[kind]:
        (run,) = (
            m
            for c in chosen.study().convergence
            for m in c.measurements
            if (m.scene, m.method, m.step) == (scene, "mujoco/euler", 0.002)
        )
        errors.append(chosen.error_of(run))
    said = _plain(_articles(text)[kind].partition('class="default">')[2].partition("</p>")[0])
    assert f"{notation.relative(max(errors))} wrong" in said
    assert notation.relative(min(errors)) in said


@pytest.mark.parametrize("kind", SCENES)
def test_no_advice_is_dominated_or_misses_an_error_that_is_reached(kind, text):
    """The advice is chosen from every setting that all scenes of the kind bound, by other code from
    the stored runs."""
    methods = [m.name for m in chosen.study().methods if m.name.startswith("mujoco/")]
    done = {
        (name, h): max(errors)
        for name in methods
        for h in (1e-3, 2e-3, 5e-3, 1e-2)
        for errors in [
            [
                _error(scene, name, h) if _trusted(scene, name) else None
                for scene in SCENES[kind]
            ]
        ]
        if None not in errors
    }
    for names, block in re.findall(
        r'<div class="advice" data-for="(.*?)".*?>(.*?)</div>', _articles(text)[kind], re.S
    ):
        method, ms = NAMED.search(block).groups()
        chosen_step, own = 1e-3 * float(ms), _error
        error = max(own(scene, method, chosen_step) for scene in SCENES[kind])
        for choice in names.split():
            step, wanted = choice.split(":")
            rivals = {
                key: e for key, e in done.items() if step == "any" or key[1] == float(step)
            }
            for (name, h), rival in rivals.items():
                cheaper = _cost(kind, name, h) < _cost(kind, method, chosen_step)
                assert not (cheaper and rival <= error), (choice, name, h)
                assert error <= float(wanted) or rival > float(wanted), (choice, name, h)


def _trusted(scene, method):
    (judged,) = (
        a.numbers.verdicts.get(method) for a in chosen.study().analyses if a.scene == scene
    )
    return judged is not None and judged.verdict in ("predicted", "converges")


def test_no_advised_step_is_within_a_fifth_of_its_limit(text):
    """Only one scene has known limits; each limit is said beside the setting."""
    limits = {
        request.method: min(limit.largest for limit in found.limits)
        for request, found in chosen.study().extras.items()
        if isinstance(request, StabilitySearch) and found.limits
    }
    assert min(limits.values()) < 0.5
    blocks = re.findall(r'class="advice".*?>(.*?)</div>', _articles(text)["arm"], re.S)
    for block in blocks:
        method, ms = NAMED.search(USE.search(block)[0]).groups()
        assert 1e-3 * float(ms) < 0.8 * limits[method]
        said = f"Stable below {notation.number(1e3 * limits[method])} ms"
        assert said in _plain(block) or limits[method] > 1e9


def test_commands_and_links_of_the_page(text, index):
    for command in re.findall(r"<code data-settings>(.*?)</code>", text):
        resolve(html.unescape(command), index.parent)
    files = site_files(index)
    assert broken_links({file: Document(file.read_text("utf-8")) for file in files}) == []


@pytest.mark.long
def test_the_address_restores_a_choice_and_the_settings_are_the_commands(
    index, browser, capsys
):
    place = "#simulate?kind=slides&step=0.002&error=0.01&friction=0.6"
    with visited(browser, index, place) as visit:
        ((kind, said),) = visit.ask(SEEN)
        snippet = visit.page.locator("#kind-slides pre:visible").inner_text()
        command = visit.page.locator("#kind-slides [data-settings]:visible").inner_text()
        visit.page.locator("[data-kind=servo].pick").click()
        visit.page.locator("[data-ask=error]").select_option("0.1")
        ((other, _),) = visit.ask(SEEN)
        kept = visit.ask("location.hash")
        assert visit.console == []
        before = visit.ask(SEEN)
    assert (kind, other) == ("slides", "servo")
    assert "Use mujoco/" in said
    assert "at 2 ms: error" in said.replace("\u00a0", " ")
    assert command.endswith("--step 0.002 --friction 0.6")
    assert main(command.split()[1:]) == 0
    printed = "".join(capsys.readouterr().out.split())
    assert "".join(snippet.split()) in printed
    assert 'friction="0.6 0.6"' in snippet
    with visited(browser, index, kept) as visit:
        assert visit.ask(SEEN) == before


# Questions, each with the place that answers it, within one screen and one click of the index, and
# with the text there in the studies whose pages are drawn here.
QUESTIONS = {
    "which step for 1 % on a sliding robot": (
        "#simulate?kind=slides&step=any&error=0.01",
        "#kind-slides",
        r"Use mujoco/\S+\+coulomb at \d\S* ms: error 0\.\d+ %",
    ),
    "is RK4 worth it": (
        "#simulate?kind=arm&error=0.001",
        "#kind-arm",
        r"default settings at 2 ms: \S+ % wrong.*Use mujoco/rk4 at .*times the default's",
    ),
    "is my integrator stable at 10 ms": (
        "#largest-step",
        ".largest-step",
        r"stable up to 2.22 s .predicted.*linear-pendulum/overdamped",
    ),
    "settings for friction 0.6 at 2 ms": (
        "#simulate?kind=slides&step=0.002&error=0.01&friction=0.6",
        "#kind-slides",
        r'timestep="2e-3".*friction="0\.6 0\.6".*--step 0\.002 --friction 0\.6',
    ),
    "how wrong is my model": ("#kind-own", "#kind-own", r"plumbob audit my\.xml"),
    "which integrator for a servo with kv": (
        "#simulate?kind=servo&step=any&error=0.01",
        "#kind-servo",
        r"Use mujoco/rk4 at .*implicitfast: it steps kv implicitly",
    ),
}


@pytest.mark.long
def test_a_question_is_answered_at_one_place(index, browser):
    with visited(browser, index) as visit:
        links = visit.ask("[...document.querySelectorAll('main a')].map((one) => one.hash)")
        for question, (place, part, said) in QUESTIONS.items():
            visit.ask("(place) => { location.hash = place; }", place)
            visit.page.wait_for_timeout(100)
            shown = visit.page.locator(part)
            visit.ask(
                "document.querySelectorAll('details').forEach((one) => { one.open = true; })"
            )
            text = " ".join(shown.inner_text().split())
            assert re.search(said, text), (question, text)
            kind = re.search(r"kind=(\w+)", place)
            assert (f"#kind-{kind[1]}" if kind else place) in links, question


@pytest.mark.long
def test_on_a_phone_a_card_leads_to_its_answer(index, browser):
    """The answer is in sight after one press."""
    with visited(browser, index, width=PHONE) as visit:
        for kind, answer in (("servo", ".use"), ("own", "code")):
            visit.page.locator(f"[data-kind={kind}].pick").click()
            visit.page.wait_for_timeout(700)  # the page scrolls smoothly
            place = visit.page.locator(f"#kind-{kind} {answer}:visible").first
            assert 0 <= place.bounding_box()["y"] < 850, kind


@pytest.mark.long
def test_without_javascript_every_kind_is_listed(index, browser):
    context = browser.new_context(java_script_enabled=False)
    try:
        page = context.new_page()
        page.goto(index.resolve().as_uri())
        shown = [
            one.get_attribute("data-kind")
            for one in page.locator(".kind").all()
            if one.is_visible()
        ]
        assert set(shown) == {*SCENES, "own"}
        assert page.locator(".ask").first.is_hidden()
        assert page.locator("#kind-slides .use").first.is_visible()
    finally:
        context.close()


@pytest.mark.long
@pytest.mark.parametrize("name", ["index", "engines"])
def test_nothing_of_a_choice_is_out_of_reach(name, index, browser):
    page = index if name == "index" else site_files(index)[1].parent / "engines.html"
    with visited(browser, page) as visit:
        assert visit.ask(SMALL) == []
        assert _faults(visit) == []
        assert visit.console == []
    for width in (DESK, PHONE):
        with visited(browser, page, width=width, scheme="dark") as visit:
            wide = visit.ask("document.documentElement.scrollWidth")
            assert wide <= width
