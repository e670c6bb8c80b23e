"""Settings on the page: the text of `plumbob settings`, which a button copies or selects."""

import html
import json
import re

import pytest

from plumbob.engines.registry import method as find_method
from plumbob.reports.cli import main
from plumbob.reports.view.page import write_file
from plumbob.reports.view.site.writing import site_content, site_in_one_file
from plumbob.tests.support.browser import visited
from plumbob.tests.support.studies import made_up, recorded

METHODS = ("mujoco/euler+coulomb", "pymunk/feet")
CODE = re.compile(r"<pre [^>]*>(.*?)</pre>", re.DOTALL)
# What a click left: the text handed to the clipboard, what the page said, what is selected.
CLICK = """<script>addEventListener("load", async () => {{
  const kept = [];
  const clipboard = {clipboard};
  Object.defineProperty(navigator, "clipboard", {{value: clipboard}});
  const seen = [];
  for (const button of document.querySelectorAll("[data-copy]")) {{
    kept.length = 0;
    for (const one of document.querySelectorAll("details")) one.open = true;
    button.focus();
    const focused = document.activeElement === button;
    button.click();
    await new Promise((done) => setTimeout(done, 20));
    seen.push({{focused, kept: kept.join(""), selected: getSelection().toString(),
      said: button.parentElement.querySelector("[role=status]").textContent}});
  }}
  const place = document.createElement("output");
  place.textContent = JSON.stringify(seen);
  document.body.append(place);
}});</script></body>"""
CLIPBOARDS = {
    "allowed": "{writeText: async (text) => { kept.push(text); }}",
    "refused": '{writeText: () => Promise.reject(new DOMException("no", "NotAllowedError"))}',
    "missing": "undefined",
}


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    study = made_up([(find_method(name), (1e-3, 1e-4), lambda h: h) for name in METHODS])
    text = site_in_one_file(site_content(recorded(study)))
    # Without plots, and so without plotly, which would take longer to load than all the rest.
    text, count = re.subn(r'class="area\b', 'class="left-out', text)
    assert count > 0
    return write_file(text, tmp_path_factory.mktemp("settings"), "index.html")


def _codes(page):
    return [html.unescape(code) for code in CODE.findall(page.read_text("utf-8"))]


@pytest.mark.parametrize("method", METHODS)
def test_it_is_what_the_command_prints(method, page, capsys):
    assert main(["settings", method, "--step", "1e-3"]) == 0
    printed = "".join(capsys.readouterr().out.split())
    shown = page.read_text("utf-8").partition(f"<code>{method}</code> at")[2]
    shown = html.unescape(shown.partition("</article>")[0])
    codes = CODE.findall(shown)
    assert len(codes) == (3 if method.startswith("mujoco") else 1)
    for said in (*codes, *re.findall(r"<dd>(.*?)</dd>", shown)):
        plain = re.sub(r"</?code[^>]*>", "`", said)  # in a sentence
        assert "".join(plain.split()) in printed


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("clipboard", CLIPBOARDS)
def test_a_click_copies_or_selects(clipboard, page, browser, tmp_path):
    seen = _clicked(browser, page.read_text("utf-8"), clipboard, tmp_path)
    assert len(seen) == len(_codes(page)) == 5
    for one, code in zip(seen, _codes(page), strict=True):
        assert one["focused"]
        if clipboard == "allowed":
            assert (one["kept"], one["said"]) == (code, "copied")
        else:
            assert "Ctrl+C" in one["said"]
            assert one["selected"].strip() == code.strip()


def _clicked(browser, text, clipboard, folder):
    """What each click on a button of the page `text` left."""
    script = CLICK.format(clipboard=CLIPBOARDS[clipboard])
    before, body, after = text.rpartition("</body>")
    assert body
    (folder / "clicked.html").write_text(before + script + after, "utf-8")
    with visited(browser, folder / "clicked.html", "#cheapest") as visit:
        visit.page.locator("output").wait_for(state="attached")
        found = json.loads(visit.ask("document.querySelector('output').textContent"))
        assert visit.console == []
    return found
