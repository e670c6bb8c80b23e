"""Chromium on a local file: its console and requests, and axe-core on what it shows."""

import os
import shutil
import subprocess
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
AXE = "axe-core@4.14.1"  # rules change with versions
SERIOUS = ("critical", "serious", "moderate")
RUN_AXE = """async ({levels, rules}) => {
  const chosen = rules.length ? {runOnly: {type: "rule", values: rules}} : {};
  const found = await axe.run(document, {resultTypes: ["violations"], preload: false, ...chosen});
  const where = (one) => one.nodes.slice(0, 3).map((node) => node.target).join(" | ");
  return found.violations.filter((one) => levels.includes(one.impact)).map((one) =>
    `${one.id} (${one.impact}) ${one.nodes.length}: ${where(one)}`);
}"""
# Two frames at each place: what comes near is seen in the first, and drawn before the second.
SCROLL = """async () => {
  for (const one of document.querySelectorAll("details")) one.open = true;
  const frame = () => new Promise((done) => requestAnimationFrame(done));
  const height = document.documentElement.scrollHeight;
  for (let place = 0; place < height; place += 1500) {
    window.scrollTo({top: place, behavior: "instant"});
    await frame();
    await frame();
  }
}"""
# The look of each element as the page stands, beside its looks so far.
LOOKS = """() => {
  for (const one of document.querySelectorAll("body *")) {
    const {color, backgroundColor, fontSize, opacity} = getComputedStyle(one);
    one.looks = [one.looks, color, backgroundColor, fontSize, opacity].join(" ");
  }
}"""
# Of elements beside each other that are alike but for their words the first stays, and one plot:
# alike in tags, attributes and all looks, and so is all that is in them. Lines keep their cells.
ALIKE = """() => {
  const valued = ["class", "style", "role", "type", "tabindex", "open", "fill", "stroke"];
  const kept = (parent) => {
    const signs = new Set();
    const all = [...parent.children].map((one) => [one, sign(one)]);
    for (const [one, own] of all) {
      if (signs.has(own) && parent.tagName !== "TR") one.remove();
      signs.add(own);
    }
    return [...signs];
  };
  const sign = (one) => {
    const given = [...one.attributes].map((each) =>
      valued.includes(each.name) || each.value === "" ? `${each.name}=${each.value}` : each.name);
    const says = [...one.childNodes].some((each) => each.nodeType === 3 && each.data.trim());
    return [one.tagName, ...given.sort(), one.looks, says, "(", ...kept(one), ")"].join(" ");
  };
  const plots = [...document.querySelectorAll(".area")];
  const drawn = plots.find((one) => one.querySelector(".main-svg"));
  for (const one of plots) if (one !== drawn) one.remove();
  kept(document.body);
}"""


def chromium():
    """The browser's program; without one the test is skipped, and fails where CI is set."""
    for name in NAMES:
        if found := shutil.which(name):
            return found
    _missing(
        "Chromium is missing (Debian: apt-get install chromium): the page was not looked at"
    )


@dataclass(frozen=True)
class Visit:
    """A page as it stands in the browser, what it wrote on the console and what it asked for."""

    page: object  # of playwright
    console: list[str]
    requests: list[str]

    def ask(self, script, *given):
        """The value of a script in the page."""
        return self.page.evaluate(script, *given)

    def violations(self, *rules):
        """What axe-core finds by these rules, or by all, minor things aside."""
        if not self.ask("'axe' in window"):
            self.ask(f"() => {{ {axe_core().read_text('utf-8')} }}")
        found = self.ask(RUN_AXE, {"levels": SERIOUS, "rules": rules})
        return found

    def until(self, script):
        """Wait until a script in the page has a true value: the page's policy allows no function
        made of text, with which playwright would do it."""
        for _ in range(1200):
            if self.ask(script):
                return
            self.page.wait_for_timeout(50)
        raise TimeoutError(script)

    def look(self, width, scheme):
        """Show the page at a width [px] in a colour scheme."""
        self.page.set_viewport_size({"width": width, "height": 900})
        self.page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
        self.page.wait_for_timeout(100)

    def keep_one_of_each(self, looks):
        """Take away what is alike, but for its words, to what stands beside it at all widths [px]
        and in all colour schemes."""
        for look in looks:
            self.look(*look)
            self.ask(LOOKS)
        self.ask(ALIKE)

    def scroll_through(self):
        """Open everything that can be opened, and scroll from the top to the end."""
        self.ask(SCROLL)


@contextmanager
def driven():
    """Chromium under playwright; where either is missing the test is skipped, and fails in CI."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _missing("playwright is missing (pip install playwright): the pages were not looked at")
    with sync_playwright() as playwright:
        options = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-background-networking"]
        browser = playwright.chromium.launch(executable_path=chromium(), args=options)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def visited(browser, page, place="", width=1280, scheme="light"):
    """A page at a width [px] in a colour scheme, loaded by a reader who prefers less motion: no
    replay plays by itself meanwhile."""
    context = browser.new_context(
        viewport={"width": width, "height": 900},
        reduced_motion="reduce",
        color_scheme="dark" if scheme == "dark" else "light",
    )
    opened = context.new_page()
    opened.set_default_timeout(120_000)
    visit = Visit(opened, [], [])
    opened.on("console", lambda message: visit.console.append(message.text))
    opened.on("pageerror", lambda error: visit.console.append(str(error)))
    opened.on("request", lambda request: _requested(visit, request.url))
    opened.goto(page.resolve().as_uri() + place)
    try:
        yield visit
    finally:
        context.close()


def _requested(visit, url):
    if not url.startswith(("blob:", "data:")):  # which the page itself holds
        visit.requests.append(url)


def axe_core():
    """The script of axe-core, from npm and kept in the user's cache; without npm the test is
    skipped, and fails in CI."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "plumbob"
    found = cache / AXE / "node_modules" / "axe-core" / "axe.min.js"
    if found.is_file():
        return found
    npm = shutil.which("npm")
    if npm is None:
        _missing("npm is missing: the pages were not checked with axe-core")
    command = [npm, "install", "--silent", "--no-save", "--prefix", str(cache / AXE), AXE]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if not found.is_file():
        _missing(f"axe-core could not be installed: {done.stderr.strip()[-200:]}")
    return found


def _missing(why):
    if os.environ.get("CI"):
        pytest.fail(why)
    pytest.skip(why)
