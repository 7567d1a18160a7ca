"""The kernel translated to C, beside the kernel that Cython compiles: the same bits."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import pytest
from hosting import library
from phaseplane.suspension import engine
from phaseplane.suspension.kernel_name import KERNEL
from phaseplane.suspension.models import build
from phaseplane.vehicle_fmus.native.image import image
from phaseplane.vehicle_fmus.native.kernel_sources import (
    plain_module,
    sources,
)
from phaseplane.vehicle_fmus.native.structure import specialised
from phaseplane.vehicle_fmus.native.translate import check, needed, number, translated

ROOTS = [("Integrator", name) for name in ("begin_row", "step_until", "sample", "sample_forces")]
MAIN = """
static Memory memory;
static double row[] = {%s};
int go(const double *times, int count, double *out) {
    Integrator *one = &memory.integrator;
    int status;
    memory_make(&memory);
    Integrator_begin_row(one, row, 0, 0.0);
    for (int k = 0; k < count; k++) {
        while ((status = Integrator_step_until(one, times[k], 0)) == PAUSED) {
            one->pace->since_pause = one->noted->logged = 0;
        }
        if (status) return status;
        Integrator_sample(one, times[k]);
        Integrator_sample_forces(one, times[k]);
        for (int i = 0; i < %d; i++) {
            *out++ = one->reading->q[i];
            *out++ = one->reading->v[i];
            *out++ = one->reading->a[i];
        }
    }
    return 0;
}
"""
RUNS = {
    "lift-off": ("QuarterCar", {}, {}),
    "curved, fixed steps": (
        "QuarterCar",
        {"spring.cubic": 1e6, "damper.saturation_force": 800.0, "friction": 50.0},
        {"method": "mean", "step": 1e-3},
    ),
    "two axles on planks": (
        "HalfCar",
        {"road.shape": "plank", "front.bump_stop.stiffness": 3e5, "road.ramp_length": 0.1},
        {"tolerance": 1e-4},
    ),
    "a spring that yields, exact": ("Elastoplastic", {}, {"method": "exact"}),
}


@pytest.mark.slow
def test_the_kernel_is_in_the_small_language() -> None:
    assert check(KERNEL) == []


@pytest.mark.slow
@pytest.mark.parametrize("is_specialised", [False, True], ids=["any system", "this system"])
@pytest.mark.parametrize("what", RUNS)
@pytest.mark.usefixtures("compiler")
def test_the_same_bits_as_the_compiled_kernel(
    what: str, is_specialised: bool, tmp_path: Path
) -> None:
    model, parameters, options = RUNS[what]
    system = build(model, parameters)
    plain = plain_module("integrator").Integrator(system, **options)
    kernel = sources(used=[type(plain.stepper.method).__name__])
    rest = [0.0] * plain.net.n
    main = MAIN % (", ".join(map(number, plain.row(system, rest, rest))), plain.net.n)
    if is_specialised:
        kernel = specialised(kernel, plain, main)
    code = translated(kernel, needed(kernel, ROOTS), main)
    code += image(plain, "integrator", kernel, "Memory").text + main
    in_c = library(code, tmp_path, "-Wall", "-Werror")
    times = [0.002 * k for k in range(501)]
    found = (ctypes.c_double * (3 * plain.net.n * len(times)))()
    given = (ctypes.c_double * len(times))(*times)
    assert in_c.go(given, len(times), found) == 0
    integrator: Any = engine.Integrator(system, **options)
    wanted: list[float] = []
    for time in times:
        assert integrator.advance(time) == 0
        integrator.sample(time)
        integrator.sample_forces(time)
        motion = (integrator.sample_q, integrator.sample_v, integrator.sample_a)
        wanted += [x for i in range(plain.net.n) for x in (array[i] for array in motion)]
    assert list(found) == wanted
