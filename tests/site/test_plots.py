"""Every plot is a picture with its labels inside it and apart, and plotly's where pressed."""

import re

import pytest

from plumbob.reports.view.drawing import separated_ticks
from plumbob.tests.support.browser import visited
from plumbob.tests.support.page_document import site_files

SCENE = "capsule-line-ca1.html"
# Of pictures, those of whose labels one is not inside, and those with two that overlap by more
# than the half pixel to which browsers round.
MISPLACED = """(pictures) => Object.entries(pictures).flatMap(([name, text]) => {
  const holder = document.body.appendChild(document.createElement("div"));
  holder.innerHTML = text;
  const svg = holder.firstElementChild, view = svg.viewBox.baseVal;
  svg.setAttribute("width", view.width);
  svg.setAttribute("height", view.height);
  const around = svg.getBoundingClientRect(), faults = [];
  const labels = [...svg.querySelectorAll("text")].filter((one) => one.textContent);
  const boxes = labels.map((one) => one.getBoundingClientRect());
  boxes.forEach((box, i) => {
    if (box.left < around.left - 1 || box.right > around.right + 1 || box.top < around.top - 3 ||
        box.bottom > around.bottom + 1) faults.push(`${name} outside: ${labels[i].textContent}`);
    boxes.slice(0, i).forEach((other, j) => {
      if (Math.min(box.right, other.right) - Math.max(box.left, other.left) > .5 &&
          Math.min(box.bottom, other.bottom) - Math.max(box.top, other.top) > 2.5)
        faults.push(`${name} overlap: ${labels[i].textContent} | ${labels[j].textContent}`);
    });
  });
  holder.remove();
  return faults;
})"""


def _pictures(index, whole):
    """The pictures of a site by file, or those of one page of each kind."""
    folder = site_files(index)[1].parent
    pages = "*.html" if whole else "cap*-line*1.html"
    pages_with = [page.read_text("utf-8") for page in sorted(folder.glob(pages))]
    names = {name for text in pages_with for name in re.findall(r'src="(\w{12}\.svg)"', text)}
    return {name: (folder / name).read_text("utf-8") for name in sorted(names)}


def test_ticks_that_would_touch_on_a_telephone_are_left_out():
    ticks = [
        (0.0, "0.001"),
        (140.0, "0.002"),
        (222.0, "0.003"),
        (280.0, "0.004"),
        (325.0, "0.005"),
    ]
    assert separated_ticks(ticks) == ticks[:-1]


@pytest.mark.long
def test_every_label_is_inside_its_picture_and_apart(index, browser, pytestconfig):
    pictures = _pictures(index, pytestconfig.getoption("--suite") != "short")
    assert len(pictures) > 2
    with visited(browser, index) as visit:
        assert visit.ask(MISPLACED, pictures) == []
        (name, text) = next(iter(pictures.items()))
        moved = re.sub(r'<text class="m" x="[\d.]+"', '<text class="m" x="2"', text)
        assert len(visit.ask(MISPLACED, {name: moved})) > 2


@pytest.mark.long
def test_a_plot_is_a_picture_until_it_is_pressed(index, browser):
    page = site_files(index)[1].parent / SCENE
    with visited(browser, page) as visit:
        plots = visit.page.locator(".area")
        for plot in plots.all():
            plot.scroll_into_view_if_needed()
        visit.until(
            "[...document.querySelectorAll('.area img')].every((one) => one.naturalWidth)"
        )
        assert not any("plotly" in url for url in visit.requests)
        _pressed(visit, 0)
        _pressed(visit, plots.count() - 1)
        visit.ask("dispatchEvent(new Event('beforeprint'))")
        assert visit.page.locator(".main-svg").count() == 0
        assert visit.page.locator(".area img:visible").count() == plots.count()
        assert visit.console == []


def _pressed(visit, place):
    plot = visit.page.locator(".area").nth(place)
    plot.locator("button").focus()
    visit.page.keyboard.press("Enter")
    plot.locator(".main-svg").first.wait_for()
    assert not plot.locator("img").is_visible()
