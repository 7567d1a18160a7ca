"""What an FMU of this project is made of, and a hash of it under which a packed one can be kept."""

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
NOT_CARRIED = ("batch.py", "many.py", "series.py")  # they need numpy, and no FMU needs them
SCRIPTS = {
    "OneDof": "one_dof.py",
    "QuarterCar": "quarter_car.py",
    "HalfCarRigidTyres": "half_car_rigid_tyres.py",
    "HalfCar": "half_car.py",
    "Elastoplastic": "elastoplastic.py",
    "Road": "road.py",
}


def content_key(model: str) -> str:
    """A hash of all that an FMU of the model is made of; one kept under it need not be built again."""
    own = Path(__file__).parent
    files = {
        f"vehicle_fmus/{path.relative_to(own).as_posix()}": path.read_bytes()
        for path in sorted(own.rglob("*"))
        if path.is_file() and path.suffix != ".pyc"
    }
    about = {"model": model.encode(), "about": json.dumps(production()).encode()}
    return digest_of({**files, **suspension_sources(), **about})[:24]


def suspension_sources() -> dict[str, bytes]:
    """The package by path: sources, what they are compiled with, and the compiled kernel if any."""
    kernel = SUSPENSION / "kernel"
    binaries = kernel / kernel_name(kernel)
    paths = [
        *(path for path in SUSPENSION.glob("*.py") if path.name not in NOT_CARRIED),
        *kernel.glob("*.py"),
        *kernel.glob("*.pxd"),  # the kernel's name is a hash of these too
        *(p for p in binaries.glob("*") if p.suffix in (".so", ".pyd")),
    ]
    return {path.relative_to(SUSPENSION).as_posix(): path.read_bytes() for path in sorted(paths)}


def production() -> dict[str, str]:
    """Attributes of the model description that say what made it, and when."""
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
        "generationDateAndTime": made,  # no clock: it would make every build another one
    }
