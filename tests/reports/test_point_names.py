"""Names beside points cover no point and no other name, whatever the points are."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from plumbob.reports.view.axis import Axis
from plumbob.reports.view.point_names import placed_names

X, Y = Axis(0.0, 4.0, 64.0, 542.0, True), Axis(-6.0, 0.0, 240.0, 10.0, True)
ENGINES = ("dart", "drake", "exudyn", "heyoka", "mjwarp", "mjx", "mujoco", "newton", "ode")
ALL = (*ENGINES, "pinocchio", "pybullet", "pymunk")
WIDTH, HEIGHT = 8.5, 16.0  # [px] of a letter of 16 px, on average, and of a line of them
PLACES = st.tuples(st.floats(X.start + 20, X.end - 20), st.floats(Y.end + 20, Y.start - 20))


def box(name):
    """The box [px] that a name covers: left, top, right, bottom."""
    width = WIDTH * len(name.text)
    left = name.x - {"": 0.0, "m": 0.5, "e": 1.0}[name.anchor] * width
    return left, name.y - 0.75 * HEIGHT, left + width, name.y + 0.25 * HEIGHT


def overlaps(names):
    """The pairs of names that cover one another."""
    boxes = [(name.text, box(name)) for name in names]
    return [
        (first, second)
        for i, (first, a) in enumerate(boxes)
        for second, b in boxes[:i]
        if a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
    ]


@pytest.mark.parametrize("apart", [0.0, 3.0, 15.0, 30.0])
def test_names_of_all_engines_with_one_error_are_apart(apart):
    points = [(150.0 + apart * i, 125.0, name) for i, name in enumerate(ALL)]
    names = placed_names(points, X, Y)
    assert sorted(name.text for name in names) == sorted(ALL)
    assert overlaps(names) == []
    moved = [name._replace(x=names[0].x, y=names[0].y) for name in names]
    assert overlaps(moved) != []


@given(st.lists(PLACES, min_size=1, max_size=len(ALL)))
def test_every_point_has_its_name_inside_the_axes_and_apart(places):
    points = [(a, b, name) for (a, b), name in zip(places, ALL, strict=False)]
    names = placed_names(points, X, Y)
    assert len(names) == len(points)
    assert overlaps(names) == []
    for name in names:
        left, top, right, bottom = box(name)
        assert X.start <= left
        assert right <= X.end
        assert Y.end <= top + 3.0  # letters are as high as a line where they have no accents
        assert bottom <= Y.start + 3.0


def test_a_name_far_from_its_point_has_a_line_to_it():
    names = placed_names([(300.0, 125.0, name) for name in ALL], X, Y)
    assert names[0].line is None
    far = [name for name in names if abs(name.y - 4.0 - 125.0) > 20.0]
    assert far
    assert all(name.line and name.line[0] == 125.0 for name in far)
