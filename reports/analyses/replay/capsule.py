"""Replays of the capsule, seen from above: feet, slider, trail, and friction at each foot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.trajectory import Trajectory
from plumbob.models.quantities import AT_REST
from plumbob.models.scene import Case
from plumbob.reports.analyses.replay.picture import (
    Chart,
    Picture,
    around,
    metres,
    radians,
)
from plumbob.reports.analyses.replay.samples import Channels

Complex = npt.NDArray[np.complex128]
ANGLES = frozenset({"x", "y", "heading", "qx", "qy"})  # held to a fraction of a pixel
LOADS = ("n1", "n2", "n3")
PAIRS = (("x", "y"), ("velocity_x", "velocity_y"))
PAD = 0.42  # of the body's size
ARROW = 0.7  # of the body's size: the friction of a foot that bears all of the weight
FINE = 1601  # samples of the exact motion, for what the charts have to show
STILL = 1e-9  # [rad]: a heading that departs by less is not mentioned
SEEN = "Seen from above; C is the body's centre of mass, A₁ to A₃ are its feet. "
FRICTION = (
    "An arrow at a foot is the friction on it: against its sliding, and longer where the normal "
    "force is larger. "
)
HELD = (
    "An arrow at a foot is the friction that holds it, drawn in proportion to the normal force; "
    "how a body at rest divides it among its feet is not determined. "
)
BESIDE = "Beside it the path of C, enlarged, and the motion over time."
MOVES = "The slider Q moves in the body, and its reaction moves and turns the body. "
FIXED = "The slider Q is fixed; friction brings the sliding body to rest. "
TEXTS: Mapping[str, str] = MappingProxyType(
    {
        "line": "The slider Q is pushed along its line with w₁ and braked with w₂; its reaction "
        "moves the body. ",
        "repeated-line": "The slider Q is pushed and braked, and goes back slowly, again and "
        "again; each time the body gains a little way. ",
        "stroke": "The slider Q moves so slowly that friction holds the body. ",
        "hold": "Nothing is to move: friction holds the body against gravity, tilted along the "
        "long arrow. ",
    }
)


def capsule(case: Case, seconds: float) -> Picture:
    """The replay of a capsule over `seconds` [s], from above, in the axes of the world."""
    setup, times = case.problem.setup, np.linspace(0.0, seconds, FINE)
    body, exact = setup.capsule, motion(case, times)
    feet = np.asarray(body.supports) @ [1.0, 1j]
    place, turned = exact["x"] + 1j * exact["y"], np.exp(1j * exact["heading"])
    size = float(np.abs(feet).max())
    slider = exact["qx"] + 1j * exact["qy"]
    corners = np.concatenate([place + turned * foot for foot in feet] + [place + turned * slider])
    geometry = {
        "feet": [[foot.real, foot.imag] for foot in feet],
        "size": size,
        "weight": body.weight,
        "arrow": ARROW * size,
        "along": setup.heading + setup.direction,
        "friction": body.friction,
        "pull": setup.pull,
        "phases": _phases(case, seconds),
        "trail": seconds,
        "strongest": float(np.hypot(exact["wx"], exact["wy"]).max()),
    }
    driven = MOVES if np.ptp(np.abs(slider - slider[0])) else FIXED
    text = SEEN + TEXTS.get(case.problem.motion.kind, driven)
    if body.friction > 0.0:
        text += HELD if case.problem.motion.kind == "hold" else FRICTION

    return Picture(
        "capsule",
        text + BESIDE,
        (*_span(corners.real, size), *_span(corners.imag, size)),
        geometry,
        _charts(case, exact, seconds),
        ANGLES,
        frozenset(),
        size,
        lambda at: motion(case, at),
        lambda run: deviations(case, run),
        lambda errors: _apart(errors, size),
        _largest,
    )


def motion(case: Case, times: Array) -> Channels:
    """Exact channels at `times` [s], shape (n,): x, y of C and its velocity in the world [m, m/s],
    heading [rad] and its rate [rad/s], place and acceleration of the slider in the body [m, m/s^2],
    normal forces [N]."""
    observed, setup = case.reference.observe(times), case.problem.setup
    place, speed = _in_world(setup, observed)
    where, _, driven = case.problem.motion.path.kinematics(times)
    return {
        "x": place.real,
        "y": place.imag,
        "heading": observed["heading"],
        "qx": where[:, 0],
        "qy": where[:, 1],
        "vx": speed.real,
        "vy": speed.imag,
        "rate": observed.get("heading_rate", np.zeros_like(times)),
        "wx": driven[:, 0],
        "wy": driven[:, 1],
        **{name: observed[f"normal_force_{i + 1}"] for i, name in enumerate(LOADS)},
    }


def deviations(case: Case, run: Trajectory) -> Channels:
    """The differences of a run from the exact pose, and from the slider's place where it observes
    that, at its own times."""
    setup, exact = case.problem.setup, case.reference.observe(run.times)
    apart = {name: run.observables.get(name, of) - of for name, of in exact.items()}
    place, _ = _in_world(setup, apart)
    ahead = apart.get("stroke", np.zeros_like(run.times)) * np.exp(1j * setup.direction)
    return {
        "x": place.real,
        "y": place.imag,
        "heading": apart["heading"],
        "qx": ahead.real,
        "qy": ahead.imag,
    }


def _in_world(setup: CapsuleSetup, observed: Channels) -> tuple[Complex, Complex]:
    """Place [m] and velocity [m/s] of C in the world, as x + iy, from observables."""
    if "displacement" in observed:
        line = np.exp(1j * (setup.heading + setup.direction))
        place = observed["displacement"] + 1j * observed["sideways"]
        return np.asarray(place * line), np.asarray(observed["velocity"] * line)
    facing = np.exp(1j * setup.heading)
    place, speed = (observed[x] + 1j * observed[y] for x, y in PAIRS)
    return np.asarray(place * facing), np.asarray(speed * facing)


def _charts(case: Case, shown: Channels, seconds: float) -> tuple[Chart, ...]:
    """The path of C, what the scene is about over time, and the normal forces."""
    about = {q.observable for q in case.system.quantities(case)}
    half = 0.58 * (max(np.ptp(shown["x"]), np.ptp(shown["y"])) or 2.0 * AT_REST)
    x, y = (0.5 * float(shown[name].min() + shown[name].max()) for name in "xy")
    box = (x - half, x + half, y - half, y + half)
    over = (0.0, seconds)
    if {"heading", "body_angle"} & about:
        label, name, values = "heading [rad]", "heading", shown["heading"]
    else:
        along = case.problem.setup.heading + case.problem.setup.direction
        values = shown["x"] * math.cos(along) + shown["y"] * math.sin(along)
        label, name = "displacement of C [m]", "displacement"
    least = 0.0 if np.ptp(values) else 2.0 * AT_REST
    charts = [
        Chart("path of C: y [m] over x [m]", "x", ("y",), box, equal=True),
        Chart(label, "t", (name,), (*over, *around(values, least=least))),
    ]
    loads = [shown[name] for name in LOADS]
    if any(map(np.ptp, loads)):
        label = "normal forces N₁, N₂, N₃ [N]"
        charts.append(Chart(label, "t", LOADS, (*over, *around(*loads)), exact_alone=True))
    return tuple(charts)


def _phases(case: Case, seconds: float) -> list[tuple[float, float, str]]:
    """When the slider is pushed and braked along a line before `seconds` [s]: from, to, symbol."""
    moving, phases = case.problem.motion, []
    if moving.kind not in ("line", "repeated-line"):
        return []
    begin, manoeuvre = 0.0, moving.manoeuvre if moving.kind == "repeated-line" else moving
    while begin < seconds:
        phases.append((begin, begin + manoeuvre.t1, "w₁"))
        phases.append((begin + manoeuvre.t1, begin + manoeuvre.t2, "w₂"))
        begin += moving.period
    return phases


def _span(places: Array, size: float) -> tuple[float, float]:
    """The view: the body wherever it goes, with a margin for arrows and labels."""
    return float(places.min()) - PAD * size, float(places.max()) + PAD * size


def _apart(errors: Channels, size: float) -> Array:
    """How far a point of the body is from where it should be at most [m], shape (n,)."""
    return np.hypot(errors["x"], errors["y"]) + size * np.abs(errors["heading"])


def _largest(errors: Channels) -> str:
    turned = float(np.abs(errors["heading"]).max())
    place = metres(float(np.hypot(errors["x"], errors["y"]).max()))
    return f"{place}, {radians(turned)}" if turned > STILL else place
