"""Pack the FMUs with pythonfmu's builder, and add the parts that it leaves out.

All FMUs loaded by a process share one `sys.modules`. The names of the modules in an FMU therefore
contain a hash of their content: equal content is loaded once, different content never mixes.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from uuid import UUID
from xml.etree import ElementTree

from phaseplane.suspension.models import FILES
from phaseplane.suspension.variables import Value

from . import systems
from .archives import digest_of, write_into, zipped
from .content import SLAVES, hashed, picture_file, production, suspension_name, suspension_sources
from .manual import DOCUMENTATION, page
from .model_description import STOP_TIME, description, written
from .reference import accepted_parameters, reference_files
from .slaves.vehicle_slave import START_VALUES
from .versions import installed
from .wrapper import ended_once

_PYTHONFMU = "resources/pythonfmu/__init__.py"
_BUILDER = b"from .builder import FmuBuilder\n"


def build(
    models: Sequence[str],
    folder: Path,
    *,
    parameters: Mapping[str, Mapping[str, object]] | None = None,
    own: Mapping[str, Path] | None = None,
    stop_times: Mapping[str, float] | None = None,
    references: bool = False,
    ssp: bool = False,
) -> list[Path]:
    """Pack models as FMI 2.0 co-simulation FMUs, `<model>.fmu` each.

    Equal sources give equal files. Either all files are written or none.

    Parameters
    ----------
    models : keys of `suspension.models.FILES` or of `own`
    folder : output folder; created if it is missing
    parameters : start values for each model that replace the defaults, as accepted by `Session`
    own : the file of each user-defined system that has been loaded
    stop_times : stop time of the default experiment of each model, s; 1 s where it is not given
    references : whether to write a reference result beside each FMU
    ssp : whether to write a system `<model>.ssp` for each vehicle that is not user-defined, in which the
        FMU `Road` provides its road

    Returns
    -------
    The files written, in the order of `models`.

    Raises
    ------
    ParameterError : unknown model or parameter, or a start value that is refused.
    RuntimeError : pythonfmu could not build an FMU (the message includes its output), or its library
        for Linux is not a known one that lets a process exit cleanly.
    """
    own, stop_times = own or {}, stop_times or {}
    files: dict[str, bytes] = {}
    roads: dict[str, bytes] = {}  # one may serve several systems
    for model, start, accepted in accepted_parameters(models, parameters or {}, own):
        stop_time = stop_times.get(model, STOP_TIME)
        files[f"{model}.fmu"] = _packed(model, start, stop_time, own.get(model))
        if references:
            files |= reference_files(model, start)
        if ssp and model not in own and systems.connections(model):
            files[f"{model}.ssp"] = _system(model, accepted, stop_time, roads)
    return write_into(folder, files)


def _system(
    model: str, parameters: Mapping[str, Value], stop_time: float, roads: dict[str, bytes]
) -> bytes:
    """Return the SSP archive of a vehicle on its road; `roads` caches packed roads by parameters."""
    road, vehicle = systems.shared_out(model, parameters)
    key = json.dumps([road, stop_time], sort_keys=True)
    if key not in roads:
        roads[key] = _packed(systems.ROAD, road, stop_time)
    return zipped(
        {
            "SystemStructure.ssd": systems.description(model, stop_time),
            f"resources/{systems.ROAD}.fmu": roads[key],
            f"resources/{model}.fmu": _packed(model, vehicle, stop_time),
        }
    )


# -- what goes in ----------------------------------------------------------------------------------


def _renamed_imports(source: bytes, names: Mapping[str, str]) -> bytes:
    """Return the source with imports of this project's modules renamed."""
    for old, new in names.items():
        source = re.sub(rf"^(\s*from) {re.escape(old)}\b".encode(), rf"\1 {new}".encode(),
                        source, flags=re.MULTILINE)  # fmt: skip
    return source


_SCRIPT = '''"""The FMU script of `{name}`."""

from phaseplane.vehicle_fmus.slaves.vehicle_slave import VehicleSlave
{before}

class {name}(VehicleSlave):
    """See the description."""

    model = {key!r}
'''
# Modules are shared by all FMUs of a process, and only a user-defined system needs this one: the
# folder of the FMU that brought the others may be gone.
_LOADING = """
import sys

from phaseplane.suspension import __name__ as package, __path__ as places

places.append(f"{{sys.path[0]}}/{{package}}")
from phaseplane.suspension.own_systems.file import load

load({text!r}, {file!r}, {key!r}, checked=False)
"""


def _script(model: str, own: Path | None) -> tuple[str, str]:
    """Return name and content of the script that pythonfmu makes an FMU from.

    The name of a user-defined model contains a hash of its file, because FMUs share their modules.
    """
    if own is None:
        return FILES[model], _SCRIPT.format(name=model, key=model, before="")
    text = own.read_text(encoding="utf-8-sig")
    key = hashed(model, text.encode())
    before = _LOADING.format(text=text, file=own.name, key=key)
    return model.lower(), _SCRIPT.format(name=model, key=key, before=before)


def _staged(
    model: str, start: Mapping[str, Value], stage: Path, own: Path | None
) -> tuple[Path, list[Path]]:
    """Write the FMU's contents to the stage; return its script, and the paths packed beside it."""
    package = suspension_sources()
    names = {"phaseplane.suspension": suspension_name(package)}
    for path, content in package.items():
        target = stage / names["phaseplane.suspension"] / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
    base = _renamed_imports((SLAVES / "vehicle_slave.py").read_bytes(), names)
    names["phaseplane.vehicle_fmus.slaves.vehicle_slave"] = hashed("vehicle_slave", base)
    base_file = stage / f"{names['phaseplane.vehicle_fmus.slaves.vehicle_slave']}.py"
    base_file.write_bytes(base)
    stem, source = _script(model, own)
    content = _renamed_imports(source.encode(), names)
    script = stage / f"{hashed(stem, content)}.py"
    script.write_bytes(content)
    start_values = stage / START_VALUES
    start_values.write_text(json.dumps(dict(sorted(start.items())), indent=1) + "\n", "utf-8")
    return script, [stage / names["phaseplane.suspension"], base_file, start_values]


def _run_pythonfmu(script: Path, beside: Sequence[Path], target: Path) -> None:
    """Run pythonfmu's builder in a separate process, because it imports what it packs."""
    command = [
        sys.executable, "-B", "-P", "-m", "pythonfmu", "build",
        "--file", str(script), "--dest", str(target), "--handle-state", "--serialize-state",
        *map(str, beside),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0 or not target.exists():
        raise RuntimeError(f"pythonfmu could not build {target.name}:\n{done.stderr.strip()}")


def _packed(
    model: str, start: dict[str, Value], stop_time: float, own: Path | None = None
) -> bytes:
    """Return the archive of one FMU."""
    with TemporaryDirectory() as work:
        stage, raw = Path(work, "stage"), Path(work, f"{model}.fmu")
        stage.mkdir()
        _run_pythonfmu(*_staged(model, start, stage, own), raw)
        with zipfile.ZipFile(raw) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
    members |= {n: _mended(members[n]) for n in members if n.startswith("binaries/linux")}
    members[_PYTHONFMU] = _without_builder(members[_PYTHONFMU])
    about = production()
    members |= {
        "model.png": picture_file(model).read_bytes(),
        "documentation/index.html": page(model, start, about["generationTool"], own).encode(),
        "documentation/externalDependencies.txt": _text("externalDependencies.txt"),
        "documentation/licenses/license.txt": _text("license.txt"),
    }
    described = description(model, start, about, stop_time=stop_time)
    members["modelDescription.xml"] = ElementTree.tostring(described)
    described.set("guid", str(UUID(hex=digest_of(members)[:32])))
    members["modelDescription.xml"] = written(described)
    return zipped(members)


def _without_builder(package: bytes) -> bytes:
    """Return pythonfmu's `__init__` such that it imports its builder, which no FMU needs, on demand.

    The builder takes longer to import than the rest of pythonfmu. A package that does not import it in
    this way is returned unchanged.
    """
    on_demand = (
        b"\n\ndef __getattr__(name):\n"
        b"    if name == 'FmuBuilder':\n"
        b"        from .builder import FmuBuilder\n"
        b"        return FmuBuilder\n"
        b"    raise AttributeError(name)\n"
    )
    return package.replace(_BUILDER, b"") + on_demand if _BUILDER in package else package


def _mended(library: bytes) -> bytes:
    """Return pythonfmu's corrected library for Linux; reject an unknown one, which might abort hosts."""
    try:
        return ended_once(library)
    except ValueError as error:
        raise RuntimeError(
            f"the Linux library of pythonfmu {installed('pythonfmu')} might abort hosts when they exit: "
            f"{error}; pack with pythonfmu 0.7.0"
        ) from error


def _text(name: str) -> bytes:
    return (DOCUMENTATION / name).read_bytes()
