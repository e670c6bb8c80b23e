"""Compiled templates are kept between processes, and no state of their folder changes a page."""

import jinja2
import pytest

from plumbob.reports.view.compiled_templates import environment

pytestmark = pytest.mark.usefixtures("cache")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """The user's cache, and beside it a template."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "greeting.html").write_text("{{ name }} & co", "utf-8")
    return tmp_path / "cache" / "plumbob" / "templates"


def filled(folder, *, autoescape=True):
    """The template as a new process would fill it."""
    fresh = environment(folder, autoescape=autoescape)
    return fresh.get_template("greeting.html").render(name="<b>")


def test_a_template_is_compiled_once(tmp_path, cache, monkeypatch):
    assert filled(tmp_path) == "&lt;b&gt; & co"
    assert len(list(cache.iterdir())) == 1
    monkeypatch.setattr(jinja2.Environment, "_generate", None)
    assert filled(tmp_path) == "&lt;b&gt; & co"


def test_a_changed_text_or_option_is_compiled_anew(tmp_path):
    filled(tmp_path)
    assert filled(tmp_path, autoescape=False) == "<b> & co"
    (tmp_path / "greeting.html").write_text("{{ name }}!", "utf-8")
    assert filled(tmp_path) == "&lt;b&gt;!"


def test_damage_is_overwritten(tmp_path, cache):
    filled(tmp_path)
    (kept,) = cache.iterdir()
    sound = kept.read_bytes()
    for damaged in (b"", b"none of ours", sound[:-9]):
        kept.write_bytes(damaged)
        assert filled(tmp_path) == "&lt;b&gt; & co"
        assert kept.read_bytes() == sound
