"""Axles that hypothesis draws, for the constructions that stand on one or two of them."""

from __future__ import annotations

from hypothesis import strategies as st
from phaseplane.suspension import roads
from phaseplane.suspension.characteristics import cubic, damper

from phaseplane.constructions import AxleData

AXLES = st.builds(
    AxleData,
    unsprung_mass=st.floats(5.0, 200.0),
    spring=st.builds(cubic, st.floats(1e3, 1e5), st.floats(0.0, 1e6)),
    damper=st.builds(damper, st.floats(0.0, 5e3), st.floats(0.0, 5e3), st.just(400.0)),
    tyre_stiffness=st.floats(5e4, 1e6),
    tyre_damping=st.floats(0.0, 3e3),
    static_load=st.floats(100.0, 2e4),
    road=st.builds(roads.bump, st.floats(-0.1, 0.1), st.floats(0.5, 3.0), st.just(20.0)),
    initial=st.tuples(
        st.floats(-0.1, 0.1), st.floats(-3.0, 3.0), st.floats(-0.1, 0.1), st.floats(-3.0, 3.0)
    ),
)
