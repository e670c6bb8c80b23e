"""The cone pendulum and the free rigid body, described."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from plumbob.reports.view.about.description import Description, Label, Symbol

DESCRIPTIONS: Mapping[str, Description] = MappingProxyType(
    {
        "cone-pendulum": Description(
            (
                "A steel cone hangs by its tip from a horizontal axle and swings without friction.",
                "The axle stands on a platform that turns about the vertical at a constant rate ω, "
                "which a drive keeps: with ω = 0 it is a usual physical pendulum.",
            ),
            (
                "H = p²/(2Iₓ) + V(θ),  p = Iₓ dθ/dt",
                "V(θ) = –a sin²θ – b sin θ – c cos θ",
                "a = ½ω²(Iᵧ – I_z),  b = MSYω²,  c = MgS",
            ),
            "H is constant along the exact motion; it follows from the source's Lagrangian, its "
            "eq. 7. The source prints another one, eq. 9: see the first finding.",
            (
                Symbol("θ", "angle of the cone from hanging straight down", "rad"),
                Symbol("ω", "rate of the platform", "rad/s"),
                Symbol("Y", "distance of the axle from the platform's axis", "m"),
                Symbol("M, S", "mass; distance of its centre from the axle", "kg, m"),
                Symbol(
                    "Iₓ, Iᵧ, I_z",
                    "moments of inertia about the tip: along the axle, across it, "
                    "along the cone's own axis",
                    "kg m²",
                ),
                Symbol("g", "gravity", "m/s²"),
            ),
            (
                Label("θ", 262, 196),
                Label("ω", 330, 318),
                Label("axle", 178, 100),
                Label("M", 312, 150),
            ),
            ("M255 110V210", "M255 182Q268 184 281 176", "M300 300Q322 297 338 282l-9 2m9-2l-2 9"),
            "A cone on an axle between two posts, on a round platform; θ is marked between the "
            "vertical and the cone, ω as an arrow along the platform's edge.",
        ),
        "free-body": Description(
            (
                "A rigid body turns about its centre, with no force or torque on it.",
                "No joint, no contact and no constant to tune: it shows what an engine's "
                "integrator does to a rotation in three dimensions.",
            ),
            (
                "I dω/dt = (Iω) × ω,  dq/dt = ½ q ω,  q(0) = 1",
                "E = ½ ω·Iω and L = q (Iω) q⁻¹ are constant",
            ),
            "Euler's equations in the body's own axes (Whittaker 1937, Analytical Dynamics, § 69). "
            "Their exact solution is by Jacobi elliptic functions, the attitude by theta functions "
            "besides. Rotations about the axes of the smallest and of the largest moment are "
            "stable; about the middle one the body turns over, again and again.",
            (
                Symbol("x, y, z", "the body's own axes, which are the world's at the start", "–"),
                Symbol("I", "moments of inertia along these axes: Iₓ, Iᵧ, I_z", "kg m²"),
                Symbol("ω", "angular velocity, along the body's axes", "rad/s"),
                Symbol("q", "attitude: a unit quaternion from the body's axes to the world's"),
                Symbol("E", "kinetic energy", "J"),
                Symbol("L", "angular momentum in the world", "kg m²/s"),
            ),
            (Label("x", 438, 287), Label("y", 336, 66), Label("z", 270, 66)),
            (
                "M342 241L430 279m-11 -1l11 1l-7 -9",
                "M272 121L330 76m-6 12l6 -12l-12 4",
                "M255 157V70m-5 10l5 -10l5 10",
            ),
            "A box that hangs in the air, with its three axes drawn as arrows: x along its longest "
            "side, y across it, z out of its top.",
        ),
    }
)
