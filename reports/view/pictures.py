"""Small pictures of figures as elements of a page: their first curves, with the page's colours."""

from __future__ import annotations

from html import escape

from plumbob.reports.view.content import Figure, Trace
from plumbob.reports.view.drawing import Frame, colour, dashes, plotted

WIDTH, HEIGHT, SQUARE = 320, 190, 308  # in their own units; the last where both axes have one scale
LEFT, RIGHT, BOTTOM = 50, 8, 34  # margins
MOST_CURVES, MOST_TICKS = 6, 4


def picture(figure: Figure) -> str:
    """A figure's first curves as an SVG element with a text for those who do not see it; empty
    where it has none that can be drawn."""
    height = SQUARE if "scaleanchor" in figure.layout["yaxis"] else HEIGHT
    frame = Frame(WIDTH, height, LEFT, RIGHT, height - BOTTOM, ticks=MOST_TICKS)
    if not (curves := _curves(figure)):
        return ""
    label = escape(f"{figure.title}. {figure.caption}")
    return (
        f'<svg class="picture" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{label}">'
        f"{plotted(figure.layout, curves, frame)}</svg>"
    )


def names(figure: Figure) -> list[tuple[str, str, str]]:
    """Names, colours and dashes, empty for a solid line, of the curves of a picture."""
    return [(t["name"], colour(t), dashes(t)) for t in _curves(figure) if t.get("name")]


def _curves(figure: Figure) -> list[Trace]:
    """The first curves of a figure that have a point on its axes."""
    logarithmic = [figure.layout[name].get("type") == "log" for name in ("xaxis", "yaxis")]

    def there(trace: Trace) -> bool:
        return (
            trace["type"] == "scatter"
            and "yaxis" not in trace
            and any(
                all(
                    v is not None and (v > 0.0 or not log)
                    for v, log in zip(at, logarithmic, strict=True)
                )
                for at in zip(trace["x"], trace["y"], strict=True)
            )
        )

    return [trace for trace in figure.traces if there(trace)][:MOST_CURVES]
