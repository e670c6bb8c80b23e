"""The cone pendulum, described."""

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
    }
)
