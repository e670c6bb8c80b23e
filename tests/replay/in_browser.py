"""Replays in a browser: a page opened, a replay stopped at a moment."""

FRACTION = 0.37  # of the replay: where each is stopped
WIDTH, HEIGHT = 1280, 900


def opened(
    browser,
    file,
    prepare=lambda page: None,
    **given,
):
    """A page for as long as it is looked at, of a reader who prefers less motion unless `given`
    says otherwise, with what `prepare` gives it before it is loaded; fails where the console said
    anything."""
    options = {
        "viewport": {"width": WIDTH, "height": HEIGHT},
        "reduced_motion": "reduce",
        **given,
    }
    page = browser.new_page(**options)
    said = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    prepare(page)
    page.goto(file.as_uri())
    yield page
    assert said == []
    page.close()


def found(page, name):
    """The replay of a scene, in sight and drawn."""
    figure = page.locator(f'[id="replay-{name.replace("/", "-")}"]')
    figure.scroll_into_view_if_needed()
    figure.locator("canvas[data-plan]").wait_for()
    return figure


def stopped(page, name):
    """The replay of a scene, at its moment, with the exact answer alone."""
    figure = found(page, name)
    for box in figure.locator("[data-layer]").all()[1:]:
        box.uncheck()
    set_time(figure, FRACTION)
    return figure


def set_time(figure, fraction):
    """Move the time to a fraction of the replay."""
    figure.locator("input[type=range]").evaluate(
        "(range, at) => { range.value = at; range.dispatchEvent(new Event('input')); }",
        round(10_000 * fraction),
    )
