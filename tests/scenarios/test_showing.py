"""A construction shown in a notebook with one call."""

from __future__ import annotations

import re
from urllib.request import urlopen

import pytest
from phaseplane.scenarios.desk import showing
from phaseplane.scenarios.desk.picture import Picture
from phaseplane.scenarios.desk.showing import Page, show
from phaseplane.scenarios.errors import InputError

SHORT = ["construction.duration=20 ms"]


@pytest.mark.slow
def test_a_figure_is_shown_as_a_picture() -> None:
    shown = show("ap57", SHORT, "storyboard", at_step=3, headed=False)
    assert isinstance(shown, Picture)
    assert shown._repr_png_().startswith(b"\x89PNG")
    assert isinstance(show("ap57_figure13", kind="figure4b"), Picture)  # takes its rule
    assert show("ap57", SHORT, width="85 mm").figure.get_figwidth() == pytest.approx(8.5 / 2.54)


@pytest.mark.slow
def test_an_animation_is_in_the_page() -> None:
    shown = show("van_der_pol", ["construction.duration=1 s"], "animation")
    assert isinstance(shown, Page)
    assert "data:image/gif;base64,R0lGOD" in shown._repr_html_()
    assert repr(shown) == "Page of van_der_pol.gif"


@pytest.mark.slow
def test_a_recording_is_served_to_this_machine() -> None:
    shown = show("ap57", SHORT, "recording", height=300)
    assert isinstance(shown, Page)
    html = shown._repr_html_()
    assert html.startswith('<div style="height:300px;')
    address = html.split('src="')[1].split('"')[0]
    assert address.startswith("http://127.0.0.1:")
    with urlopen(address.split("?")[0]) as page:
        assert page.status == 200
    showing._open.close()  # as at the end of a notebook


@pytest.mark.parametrize("height", [640, 768, 1000])
def test_nothing_of_a_recording_is_cut_off_in_a_notebook(height: int) -> None:
    """In a frame of 640 pixels the present stage was below its pane, and lanes were half seen."""
    html = showing._frame("http://127.0.0.1:9090", height)
    inner, across, scale = (
        float(re.search(pattern, html.partition("iframe")[2])[1])
        for pattern in (r";height:(\d+)px", r"[^-]width:([\d.]+)%", r"scale\(([\d.]+)\)")
    )
    assert inner >= 768.0
    assert inner * scale == pytest.approx(height, abs=1.0)
    assert across * scale == pytest.approx(100.0, abs=0.1)


def test_what_cannot_be_shown_is_refused() -> None:
    with pytest.raises(InputError, match="font: font 'None Such' is not installed"):
        show("ap57", SHORT, font="None Such")
    with pytest.raises(InputError, match="width 85: must be from 40 mm to 1 m"):
        show("ap57", SHORT, width=85)
    with pytest.raises(ValueError, match="time_histories shows a run"):
        show("ap57", SHORT, "time_histories")
    with pytest.raises(InputError, match=r"^show\(\): changes = 'speed=3': give a mapping"):
        show("ap57", "speed=3")
    with pytest.raises(InputError, match=r"^show\(\): .*did you mean 'speed'"):
        show("ap57", {"sped": 3})
    with pytest.raises(InputError, match="no picture 'figure77'; pictures are time_histories, "):
        show("ap57", SHORT, "figure77")
