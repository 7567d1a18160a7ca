"""The contents of an FMU of this project, and a hash of them by which a packed FMU can be cached."""

from __future__ import annotations

import json
import os
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from phaseplane.suspension.kernel_name import KERNEL, kernel_name

from .archives import digest_of

SUSPENSION = KERNEL.parent
SLAVES = Path(__file__).parent / "slaves"
NOT_CARRIED = ("batch.py", "many.py", "series.py")  # need numpy, and are not needed in an FMU
SCRIPTS = {
    "OneDof": "one_dof.py",
    "QuarterCar": "quarter_car.py",
    "HalfCarRigidTyres": "half_car_rigid_tyres.py",
    "HalfCar": "half_car.py",
    "Elastoplastic": "elastoplastic.py",
    "Road": "road.py",
}


def content_key(model: str) -> str:
    """Return a hash of everything an FMU of the model is made of, the key of a cached FMU."""
    own = Path(__file__).parent
    files = {
        f"vehicle_fmus/{path.relative_to(own).as_posix()}": path.read_bytes()
        for path in sorted(own.rglob("*"))
        if path.is_file() and path.suffix != ".pyc"
    }
    about = {"model": model.encode(), "about": json.dumps(production()).encode()}
    return digest_of({**files, **suspension_sources(), **about})[:24]


def suspension_sources() -> dict[str, bytes]:
    """Return the package by path: sources, declarations for Cython, and the compiled kernel if any."""
    kernel = SUSPENSION / "kernel"
    binaries = kernel / kernel_name(kernel)
    paths = [
        *(path for path in SUSPENSION.glob("*.py") if path.name not in NOT_CARRIED),
        *kernel.glob("*.py"),
        *kernel.glob("*.pxd"),  # the kernel's name depends on these too
        *(p for p in binaries.glob("*") if p.suffix in (".so", ".pyd")),
    ]
    return {path.relative_to(SUSPENSION).as_posix(): path.read_bytes() for path in sorted(paths)}


def production() -> dict[str, str]:
    """Return the attributes of the model description that record version, tool and date."""
    try:
        own = version("phaseplane")
    except PackageNotFoundError:  # run from its sources
        own = ""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    made = datetime.fromtimestamp(int(epoch), UTC).isoformat()[:19] + "Z" if epoch else ""
    return {
        "guid": "",
        "version": own,
        "generationTool": f"{f'phaseplane {own}'.strip()} with PythonFMU {version('pythonfmu')}",
        "generationDateAndTime": made,  # not the clock, with which every build would differ
    }
