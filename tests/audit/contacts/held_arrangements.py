"""Bodies at rest whose statics has a closed form, as model files. Each is drawn at a fraction of
its limit: what it needs of friction, over what it has. Above 1 friction cannot hold it."""

import math
from dataclasses import dataclass

from plumbob.analytic.systems.stack import Stack

G = 9.81
HEAD = '<mujoco><option timestep="0.002"/><worldbody>'
HOLDS, PRELOAD, CANNOT = "holds", "can hold with a preload", "cannot hold"


@dataclass(frozen=True)
class Arrangement:
    """A model with the answer of its closed form."""

    name: str
    text: str
    coulomb: str
    friction: float | None = None  # smallest multiple of the friction; None: not compared
    force: float | None = None  # smallest largest normal force between two bodies [N]
    keyframe: str | None = None  # keyframe of the start


def gripping(controls):
    """A keyframe with some controls."""
    numbers = " ".join(f"{control:.17g}" for control in controls)
    return f'<keyframe><key name="grip" ctrl="{numbers}"/></keyframe></mujoco>'


def verdict(fraction, held=HOLDS):
    return held if fraction <= 1.0 else CANNOT


def degrees(angle):
    return f"{math.degrees(angle):.15g}"


def on_slope(slope, friction, bodies, heading=0.0):
    """A slope through the origin, with bodies that are given in its own axes: x is uphill."""
    floor = f'<geom type="plane" size="9 9 1" friction="{friction:.17g}"/>'
    cos, sin = math.cos(slope), math.sin(slope)
    gravity = -G * sin * math.cos(heading), -G * sin * math.sin(heading), -G * cos
    option = f'<option gravity="{gravity[0]:.17g} {gravity[1]:.17g} {gravity[2]:.17g}"/>'
    return f"{HEAD}{floor}{bodies}</worldbody>{option}</mujoco>"


def block(draw, fraction):
    """A block that would slide first, pulled in any direction."""
    friction = draw.uniform(0.1, 0.9)
    height = draw.uniform(0.05, 0.9) * 0.1 / friction
    body = (
        f'<body pos="0 0 {height:.17g}"><freejoint/>'
        f'<geom type="box" size=".1 .1 {height:.17g}" mass="{draw.uniform(0.1, 9)}"'
        f' friction="{friction:.17g}"/></body>'
    )
    slope = math.atan(fraction * friction)
    text = on_slope(slope, friction, body, draw.uniform(-math.pi, math.pi))
    # A block that slides at once may tip, too: then no friction would hold it.
    return Arrangement("block", text, verdict(fraction), fraction if fraction < 1.0 else None)


def chair(draw, fraction):
    """A chair on four round feet that tips first, about its lower legs."""
    reach, height = draw.uniform(0.1, 0.3), draw.uniform(0.2, 0.6)
    feet = "".join(
        f'<geom type="sphere" size=".01" mass="0" pos="{x:.17g} {y} {0.01 - height:.17g}"'
        ' friction="2"/>'
        for x in (-reach, reach)
        for y in (-0.2, 0.2)
    )
    body = (
        f'<body pos="0 0 {height:.17g}"><freejoint/><inertial pos="0 0 0" mass="3" '
        f'diaginertia=".1 .1 .1"/>{feet}</body>'
    )
    slope = math.atan(fraction * reach / height)
    return Arrangement("chair", on_slope(slope, 2.0, body), verdict(fraction))


def stack(draw, fraction):
    """Cubes that slide or topple first, whichever their friction decides."""
    cubes = Stack(draw.choice((2, 3)), 0.1, 1.0, draw.uniform(0.5, 3.0), G)
    slides = draw.random() < 0.5
    friction = (0.5 if slides else 1.5) * math.tan(cubes.topples)
    limit = friction if slides else math.tan(cubes.topples)
    bodies = "".join(
        f'<body pos="0 0 {0.05 + 0.1 * k:.17g}"><freejoint/><geom type="box" '
        f'size=".05 .05 .05" mass="{mass:.17g}" friction="{friction:.17g}"/></body>'
        for k, mass in enumerate(cubes.masses)
    )
    text = on_slope(math.atan(fraction * limit), friction, bodies)
    return Arrangement("stack", text, verdict(fraction), fraction if slides else None)


def leaning_rod(draw, fraction):
    """A rod that leans between a wall and a floor: at the limit the friction of both is used up."""
    angle, radius, half = draw.uniform(0.7, 1.2), 0.01, 1.0
    wall = draw.uniform(0.1, 0.6)
    foot, top = half * math.cos(angle), half * math.sin(angle)
    # The wall is at x = 0, the floor at z = 0; the ends are half spheres.
    x, z = 2 * foot + radius, 2 * top + radius
    # Forces over the weight at the limit; the centre of mass is above `foot + radius`.
    normal = (x - foot - radius) / (z + wall * x)
    needed = normal / (1.0 - wall * normal)
    floor = needed / fraction
    text = (
        f'{HEAD}<geom name="floor" type="plane" size="9 9 1"/>'
        '<geom name="wall" type="plane" size="9 9 1" zaxis="1 0 0"/>'
        f'<body pos="{foot + radius:.17g} 0 {top + radius:.17g}"><freejoint/>'
        f'<geom name="rod" type="capsule" size="{radius}" '
        f'fromto="{foot:.17g} 0 {-top:.17g} {-foot:.17g} 0 {top:.17g}" mass="8"/></body>'
        '</worldbody><contact><pair geom1="floor" geom2="rod" '
        f'friction="{floor:.17g} {floor:.17g}"/><pair geom1="wall" geom2="rod" '
        f'friction="{wall:.17g} {wall:.17g}"/></contact></mujoco>'
    )
    return Arrangement("leaning rod", text, verdict(fraction))


def gripper(fingers, body, force):
    """Fingers on slides that press with a force along the inward normal of each."""
    parts, motors = [], []
    for number, angle in enumerate(fingers):
        cos, sin = math.cos(angle), math.sin(angle)
        parts.append(
            f'<body pos="{0.06 * cos:.17g} {0.06 * sin:.17g} 0" euler="0 0 {degrees(angle)}">'
            f'<joint name="j{number}" type="slide" axis="-1 0 0"/>'
            f'<geom type="box" size=".01 .05 .05" mass=".1" friction="{body[1]:.17g}"/></body>'
        )
        motors.append(f'<motor joint="j{number}"/>')
    text = (
        f"{HEAD}{''.join(parts)}<body><freejoint/>{body[0]}</body></worldbody>"
        f"<actuator>{''.join(motors)}</actuator>{gripping([force] * len(fingers))}"
    )
    return text


def pinch(draw, fraction):
    """A box between two fingers."""
    mass, friction = draw.uniform(0.05, 2.0), draw.uniform(0.2, 1.2)
    force = mass * G / (2.0 * friction * fraction)
    body = (
        f'<geom type="box" size=".05 .02 .02" mass="{mass:.17g}" friction="{friction:.17g}"/>'
    )
    text = gripper((0.0, math.pi), (body, friction), force)
    return Arrangement("pinch", text, verdict(fraction), fraction, keyframe="grip")


def three_fingers(draw, fraction):
    """A ball between three fingers."""
    mass, friction = draw.uniform(0.05, 2.0), draw.uniform(0.2, 1.2)
    force = mass * G / (3.0 * friction * fraction)
    body = f'<geom type="sphere" size=".05" mass="{mass:.17g}" friction="{friction:.17g}"/>'
    first = draw.uniform(0.0, 2.0)
    angles = tuple(first + k * math.tau / 3.0 for k in range(3))
    text = gripper(angles, (body, friction), force)
    return Arrangement("three fingers", text, verdict(fraction), fraction, keyframe="grip")


def hinged_fingers(draw, fraction):
    """A box between two fingers on hinges, pressed at the lever arm of the box."""
    mass, friction, lever = draw.uniform(0.05, 1.0), draw.uniform(0.2, 1.2), 0.1
    # The load pulls each finger open about its hinge, at the finger's radius from it.
    radius = 0.01
    torque = mass * G * (lever / friction + radius) / (2.0 * fraction)
    parts = "".join(
        f'<body pos="{side * 0.06} 0 {lever}" gravcomp="1"><joint name="{name}" axis="0 {side} 0"/>'
        f'<geom type="sphere" size="{radius}" pos="0 0 {-lever}" mass=".1" '
        f'friction="{friction:.17g}"/></body>'
        for side, name in ((-1, "l"), (1, "r"))
    )
    text = (
        f"{HEAD}{parts}<body><freejoint/><geom type='box' size='.05 .02 .02' mass='{mass:.17g}' "
        f"friction='{friction:.17g}'/></body></worldbody><actuator><motor joint='l'/>"
        f"<motor joint='r'/></actuator>{gripping((torque, torque))}"
    )
    return Arrangement("hinged fingers", text, verdict(fraction), keyframe="grip")


def between_walls(draw, fraction):
    """A box between two fixed walls: any friction holds it, at a preload."""
    mass, friction = draw.uniform(0.1, 5.0), draw.uniform(0.1, 1.5) * fraction
    walls = "".join(
        f'<geom type="box" size=".05 1 1" pos="{x} 0 0" friction="{friction:.17g}"/>'
        for x in (-0.15, 0.15)
    )
    text = (
        f'{HEAD}{walls}<body><freejoint/><geom type="box" size=".1 .1 .1" mass="{mass:.17g}" '
        f'friction="{friction:.17g}"/></body></worldbody></mujoco>'
    )
    return Arrangement("between walls", text, PRELOAD, force=mass * G / (2.0 * friction))


def wedge(draw, fraction, pulled=True):
    """A ball in a groove of two walls that gravity pulls out of the groove, or into it."""
    mass, angle, radius = draw.uniform(0.1, 5.0), draw.uniform(0.1, 0.6), 0.05
    away, up = (radius + 0.02) * math.cos(angle), (radius + 0.02) * math.sin(angle)
    friction = math.tan(angle) / fraction
    walls = "".join(
        # A wall's inner face touches the ball at the angle below its equator, or above it.
        f'<geom type="box" size=".02 1 1" friction="{friction:.17g}" '
        f'pos="{side * away:.17g} 0 {sign * up:.17g}" '
        f'euler="0 {degrees(-side * sign * angle)} 0"/>'
        for sign in (1 if pulled else -1,)
        for side in (-1, 1)
    )
    text = (
        f'{HEAD}{walls}<body><freejoint/><geom type="sphere" size="{radius}" mass="{mass:.17g}" '
        f'friction="{friction:.17g}"/></body></worldbody></mujoco>'
    )
    if not pulled:
        return Arrangement("groove", text, HOLDS)
    force = None
    if fraction < 1.0:
        force = mass * G / (2.0 * (friction * math.cos(angle) - math.sin(angle)))
    return Arrangement("wedge", text, verdict(fraction, PRELOAD), fraction, force)


def groove(draw, fraction):
    """A ball that its weight presses into a groove: it holds with any friction."""
    return wedge(draw, fraction, pulled=False)


KINDS = (
    block,
    chair,
    stack,
    leaning_rod,
    pinch,
    three_fingers,
    hinged_fingers,
    between_walls,
    wedge,
    groove,
)
FRACTIONS = ((0.3, 0.97), (0.985, 1.0), (1.0, 1.015), (1.03, 2.0))
