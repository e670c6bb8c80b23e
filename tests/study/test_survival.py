"""A study that is ended before its time goes on: nothing lost, nothing done twice, same figures."""

import signal
from collections import Counter

import pytest

from plumbob.engines.study.checkpoint import Checkpoint
from plumbob.reports.cli import main
from plumbob.tests.study import disturbed

OLD = """<meta content="default-src 'none';"><title>plumbob: an older study</title>"""


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A folder with the study as it is when nothing ends it."""
    out = tmp_path_factory.mktemp("undisturbed")
    assert main(disturbed.words(out, 1)) == 0
    return out


@pytest.fixture
def out(tmp_path):
    """A folder with an older page."""
    (tmp_path / "index.html").write_text(OLD)
    return tmp_path


def _ended(process):
    """How a study ends, and what it says."""
    said, _ = disturbed.ended(process)
    return process.returncode, said


@pytest.mark.rare(keep=3)
@pytest.mark.long
@pytest.mark.parametrize(
    ("number", "moment"),
    [(signal.SIGKILL, 1), (signal.SIGTERM, 3), (signal.SIGINT, 6), (signal.SIGKILL, 6)],
)
def test_a_study_goes_on_after_a_signal(number, moment, out, undisturbed, capsys, monkeypatch):
    code, said = _ended(disturbed.begun(out, 1, moment, int(number)))
    assert code == (-signal.SIGKILL if number == signal.SIGKILL else 130)
    assert number == signal.SIGKILL or said == (
        "plumbob: interrupted; what is measured is stored: the same command goes on from there\n"
    )
    assert (out / "index.html").read_text() == OLD
    monkeypatch.setattr(Checkpoint, "keep", disturbed.listing(out / "log"))
    assert main(disturbed.words(out, 1)) == 0
    err = capsys.readouterr().err
    assert ("goes on: " in err) == (moment > 1)
    counts = Counter(disturbed.logged(out))
    assert set(counts.values()) == {1}
    # Two pairs, four extra runs, one drawing, one reading of models, costs of a scene, three
    # largest steps, measured or predicted, and the search of a derivative.
    assert len(counts) == 13
    assert disturbed.figures(out) == disturbed.figures(undisturbed)
    # with seven analyses (three of them have their numbers shipped), what a scene's page takes,
    # what all pages take, and a list
    assert disturbed.rows(out) == (1, 23)
    assert (out / "index.html").read_text() != OLD


@pytest.mark.long
def test_a_second_process_waits_for_the_first(out, undisturbed, capsys):
    first = disturbed.begun(out, 1)
    disturbed.until(lambda: len(disturbed.logged(out)) > 0, first)
    assert first.poll() is None
    assert main(disturbed.words(out, 1)) == 0
    assert "waits for another process" in capsys.readouterr().err
    assert _ended(first) == (0, "")
    assert disturbed.rows(out)[0] == 2
    assert disturbed.figures(out) == disturbed.figures(undisturbed)


@pytest.mark.long
@pytest.mark.parametrize(
    ("limit", "said"),
    [
        (30_000, "store = "),
        (90_000, "store = "),
        (1_500_000, "the study is stored: `plumbob re"),
    ],
)
def test_a_full_disk_loses_nothing(limit, said, out, undisturbed):
    code, err = _ended(disturbed.begun(out, 1, limit=limit))
    assert code == 2
    assert err.count("\n") == 1
    assert said in err
    assert (out / "index.html").read_text() == OLD
    assert main(disturbed.words(out, 1)) == 0
    assert disturbed.figures(out) == disturbed.figures(undisturbed)
