"""Frames stored as columns are the same frames."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recorded import drawing, frame

from phaseplane.constructions.primitives import Frame
from phaseplane.constructions.storage import StoredFrames
from phaseplane.picture.frames import columns, table

numbers = st.floats(allow_nan=False)
names = st.sampled_from(["P", "D", "P'", "A*"])
frames = st.builds(
    Frame,
    step=st.integers(0, 10**9),
    time=numbers,
    duration=numbers,
    scheme=st.sampled_from(["contact", "flight"]),
    points=st.dictionaries(names, st.complex_numbers(allow_nan=False)),
    readings=st.dictionaries(names, numbers),
    event=st.sampled_from(["", "lift_off", "jolt"]),
)


@pytest.mark.slow
@given(made=st.lists(frames, max_size=12), cut=st.slices(12))
def test_frames_come_back_as_they_were(made: list[Frame], cut: slice) -> None:
    stored = StoredFrames(made)
    assert list(stored) == made
    assert stored == made
    assert list(stored[cut]) == made[cut]
    places = list(range(len(made)))[cut]
    assert list(stored.at(places)) == [made[i] for i in places]
    assert stored.schemes == [frame.scheme for frame in made]
    assert stored.events == {i: frame.event for i, frame in enumerate(made) if frame.event}
    assert stored.times == [frame.time for frame in made]
    assert stored.steps == [frame.step for frame in made]
    assert pickle.loads(pickle.dumps(stored)) == made


@pytest.mark.slow
@given(made=st.lists(frames, min_size=1, max_size=12), chosen=st.lists(names, max_size=3))
def test_columns_are_those_of_the_frames(made: list[Frame], chosen: list[str]) -> None:
    stored = StoredFrames(made)[::-1]
    wanted = [[frame.points.get(name, np.nan) for name in chosen] for frame in reversed(made)]
    np.testing.assert_array_equal(columns(stored, chosen), np.array(wanted, complex))
    wanted = [[frame.readings.get(name, np.nan) for name in chosen] for frame in reversed(made)]
    np.testing.assert_array_equal(columns(stored, chosen, "readings"), np.array(wanted, float))
    for name in chosen:
        own = [frame.points[name] for frame in reversed(made) if name in frame.points]
        assert list(stored.points(name)) == own


def test_a_frame_that_lacks_a_point_is_named() -> None:
    with pytest.raises(ValueError, match="step 3 of the construction has no point 'Q'"):
        table(drawing(9).frames[3:], ["P1", "Q"])


def test_a_step_takes_a_tenth_of_the_memory_of_its_objects() -> None:
    stored = StoredFrames(frame(k) for k in range(1000))
    size = len(pickle.dumps(stored))  # the columns, and their names once
    assert size < 1000 * (6 * 16 + 2 * 8 + 6 * 8) + 3000
