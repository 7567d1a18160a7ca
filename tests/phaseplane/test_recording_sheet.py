"""What is written and drawn on the sheet, and what it looks like."""

from __future__ import annotations

import cmath
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recorded import (
    CONTACT_SCHEME,
    PLANES,
    Recorded,
    drawing,
    frame,
)

from phaseplane.constructions import (
    Axis,
    Curve,
    Mark,
    Scheme,
)
from phaseplane.recording import record
from phaseplane.recording.sheet import Bounds, arcs, letters, ticks
from phaseplane.recording.styles import STYLES, legible


@given(
    low=st.floats(-100.0, 0.0),
    span=st.floats(1e-3, 100.0),
    part=st.floats(0.02, 0.5),
    unit=st.sampled_from(["m", "rad"]),
    scale=st.floats(0.01, 100.0),
    direction=st.sampled_from([1 + 0j, -1 + 0j, 1j]),
)
def test_ticks_stand_where_their_label_says(
    *, low: float, span: float, part: float, unit: str, scale: float, direction: complex
) -> None:
    axis = Axis("y", unit, 0.1 - 0.2j, direction, scale)
    reach = max(low + span, 0.0) - low
    spacing = part * reach * scale
    graduation = ticks(axis, [low, low + span], spacing)
    factors = {"m": 1.0, "cm": 0.01, "mm": 0.001, "rad": 1.0}
    values = []
    for tick in graduation:
        number, name = tick.label.replace("\N{MINUS SIGN}", "-").split()
        values.append(float(number) * factors[name])
        assert axis.read(tick.place) == pytest.approx(values[-1], rel=1e-4, abs=1e-12)
    steps = np.diff(sorted([*values, 0.0]))
    assert steps == pytest.approx(np.full(len(steps), steps[0]), rel=1e-3)
    assert f"{steps[0]:.1e}"[:3] in ("1.0", "2.0", "5.0")
    assert 0.999 * spacing <= steps[0] * scale <= 2.51 * spacing
    covered = 0.05 * steps[0] * 1.001
    assert min([*values, 0.0]) <= low + covered
    assert max([*values, 0.0]) >= low + span - covered


angles = st.floats(-pi + 1e-3, pi - 1e-3)


@given(radius=st.floats(1e-3, 10.0), start=angles, turn=angles, far=st.floats(0.1, 10.0))
def test_arcs_are_the_shorter_ones(radius: float, start: float, turn: float, far: float) -> None:
    centre = np.array([[0.3 - 0.7j]])
    begin = centre + radius * np.exp(1j * start)
    end = centre + far * np.exp(1j * (start + turn))
    polyline = arcs(centre, begin, end)[0, 0]
    spokes = polyline - centre[0, 0]
    assert abs(spokes) == pytest.approx(np.full(len(spokes), radius))
    assert polyline[0] == pytest.approx(begin[0, 0])
    assert cmath.phase(spokes[-1] / (end - centre)[0, 0]) == pytest.approx(0.0, abs=1e-9)
    assert np.sum(np.angle(spokes[1:] / spokes[:-1])) == pytest.approx(turn)
    assert np.max(abs(np.angle(spokes[1:] / spokes[:-1]))) <= 0.1


def test_letters_on_one_spot_are_moved_apart() -> None:
    scheme = Scheme(("all",), (Mark("state", "C1", 0, "C1"), Mark("state", "C2", 0, "C2")))
    near = replace(frame(0), points={"C1": 0j, "C2": 0.0004j})
    apart = replace(frame(0), points={"C1": 0j, "C2": 0.1 + 0j})
    box = Bounds(-0.2, 0.2, -0.2, 0.2)
    left, right = letters(scheme, [near], box).values()
    assert {left.index("C"), right.index("C")} == {0, 6}
    free = list(letters(scheme, [apart], box).values())
    assert free == ["C\N{SUBSCRIPT ONE}", "C\N{SUBSCRIPT TWO}"]


def test_no_text_holds_a_character_that_ends_the_viewer(tmp_path: Path) -> None:
    strange = "a\N{BRAILLE PATTERN BLANK}b"
    plane = replace(PLANES[0], displacement=replace(PLANES[0].displacement, label=strange))
    scheme = replace(
        CONTACT_SCHEME, stages=(strange,) * 3, marks=(Mark("state", "P1", 0, strange),)
    )
    odd = replace(
        drawing(25),
        title=strange,
        planes=(plane,),
        curves=(Curve("line", (0j, 1 + 0j), strange),),
        schemes={"contact": scheme},
        frames=(replace(frame(0), readings={strange: 1.0}, event=strange), frame(1)),
    )
    times = {"time": [0.0, 1.0], f"{strange}_displacement": [0.0, 1.0]}
    record(odd, tmp_path / "f.rrd", times)
    texts = [text for text in Recorded(tmp_path / "f.rrd").words() if "a?b" in text]
    assert len(texts) >= 8
    assert all(text == legible(text) for text in Recorded(tmp_path / "f.rrd").words())


def test_what_the_viewer_can_show_is_kept() -> None:
    kept = "x\N{SUBSCRIPT TWO} \N{GREEK CAPITAL LETTER OMEGA} \N{MINUS SIGN}1 A1*'\n"
    assert legible(kept) == kept
    assert legible("y\N{COMBINING MACRON}") == "\N{LATIN SMALL LETTER Y WITH MACRON}"


def luminance(colour: int) -> float:
    """Relative luminance of 0xRRGGBBAA, as the contrast ratios of the web are made from."""
    channels = np.array([*colour.to_bytes(4)[:3]]) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


@pytest.mark.parametrize("role", STYLES)
def test_roles_stand_out_on_dark_and_on_light(role: str) -> None:
    colour = STYLES[role].colour
    assert colour & 0xFF == 0xFF
    dark, light = luminance(0x0D0D0DFF), luminance(0xFFFFFFFF)
    assert (luminance(colour) + 0.05) / (dark + 0.05) > 2.5
    assert (light + 0.05) / (luminance(colour) + 0.05) > 2.5
