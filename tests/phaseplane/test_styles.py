"""Hues and weights of a picture stand out on their ground, light or dark."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from phaseplane.picture.styles import (
    INK,
    MOVING_POINT,
    PAPER,
    PARTS,
    ROLES,
    Hue,
    hue_of,
    part_of,
    style_of,
)
from phaseplane.recording.canvas import rgba


def luminance(colour: str) -> float:
    """The relative luminance of a colour #rrggbb, from 0 (black) to 1 (white)."""
    red, green, blue = (
        c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4
        for c in (int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: str, other: str) -> float:
    """The contrast of two colours, from 1 to 21."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


HUES = {**{r: s.hue for r, s in ROLES.items() if r not in ("halo", "here")}, **PARTS}


@pytest.mark.parametrize("name", HUES)
def test_hues_stand_out_on_their_ground(name: str) -> None:
    hue: Hue = HUES[name]
    assert contrast(hue.light, PAPER.light) >= 4.5
    assert contrast(hue.dark, PAPER.dark) >= 4.5
    assert min(contrast(hue.on("either"), g) for g in (PAPER.light, PAPER.dark)) >= 4.0
    assert INK.on("light") == INK.light


def test_the_moving_point_stands_out_on_any_ground() -> None:
    halo, here, state = (style_of(role) for role in MOVING_POINT)
    assert halo.size > here.size > 1.3 * state.size
    for ground in (PAPER.light, PAPER.dark):
        assert max(contrast(disc.hue.on("either"), ground) for disc in (halo, here)) >= 12.0
    assert contrast(state.hue.on("either"), here.hue.on("either")) >= 4.0


@given(strength=st.floats(0.1, 0.9), hue=st.sampled_from(list(PARTS.values())))
def test_weak_lines_stand_out_less_on_any_ground(*, strength: float, hue: Hue) -> None:
    weak = rgba(hue, strength)
    assert weak & 255 == 255  # the viewer does not blend lines with their ground
    shade = f"#{weak >> 8:06x}"
    for ground in (PAPER.light, PAPER.dark):
        assert contrast(shade, ground) < 1.1 * contrast(hue.on("either"), ground)
    red, green, blue = (int(shade[i : i + 2], 16) for i in (1, 3, 5))
    full = [int(hue.on("either")[i : i + 2], 16) for i in (1, 3, 5)]
    assert np.ptp([red, green, blue]) < np.ptp(full)


@pytest.mark.parametrize("name", ["permanent_set", "displacement", "wheel_displacement"])
@pytest.mark.parametrize("number", range(4))
def test_a_column_has_the_same_hue_in_the_chart_and_in_the_plots(name: str, number: int) -> None:
    role = part_of(name) or list(PARTS)[number]
    assert style_of(role).hue == hue_of(name, number)
