"""Pack native FMUs: binaries and sources that need nothing from their host."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from uuid import UUID

from phaseplane.suspension.variables import Value

from ..archives import digest_of, write_into, zipped
from ..content import picture_file, production
from ..manual import DOCUMENTATION, page
from ..model_description import STOP_TIME, description, written
from ..reference import accepted_parameters, declared_inside, reference_files
from . import description3
from .compilers import FLAGS, Platform, chosen, compiled
from .model import model_in_c

_C = Path(__file__).parent / "c"
HEADERS = Path(find_spec("fmpy").origin).parent / "c-code"  # type: ignore[union-attr,arg-type]
"""The headers of the FMI standard, as FMPy has them."""
_LAYERS = {
    2: ("fmi2.c", "fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("fmi3.c", "fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
VERSIONS = tuple(_LAYERS)
"""Versions of FMI for which native FMUs are packed."""
_ALL = """\
/* {model}, all of it: compile this file alone, with {flags}. */

#define GUID "{token}"
#include "core.h"
#include "model.c"
#include "core.c"
#include "{layer}"
"""


def build(
    models: Sequence[str],
    folder: Path,
    *,
    fmi: int = 2,
    platforms: Sequence[str] = (),
    parameters: Mapping[str, Mapping[str, object]] | None = None,
    own: Mapping[str, Path] | None = None,
    stop_times: Mapping[str, float] | None = None,
    references: bool = False,
) -> list[Path]:
    """Pack models as native co-simulation FMUs, `<model>.fmu` each.

    Equal sources and compilers give equal files. Either all files are written or none.

    Parameters
    ----------
    models : keys of `models.FILES` or of `own`
    folder : output folder; created if it is missing
    fmi : 2 or 3, the version of FMI
    platforms : names in `compilers.PLATFORMS`; by default the one at hand, or all if zig is installed
    parameters : start values for each model that replace the defaults, as accepted by `Session`; texts,
        switches and what decides on the structure cannot be changed in the FMU
    own : the file of each user-defined system that has been loaded
    stop_times : stop time of the default experiment of each model, s; 1 s where it is not given
    references : whether to write a reference result beside each FMU, and into it

    Returns
    -------
    The files written, in the order of `models`.

    Raises
    ------
    ParameterError : unknown model or parameter, or a start value that is refused.
    ValueError : unknown version or platform, or a platform without a compiler.
    RuntimeError : a compiler failed (the message includes its output).
    """
    own, stop_times = own or {}, stop_times or {}
    if fmi not in VERSIONS:
        raise ValueError(f"FMI {fmi}: native FMUs are packed for {' or '.join(map(str, VERSIONS))}")
    targets = chosen(platforms)
    files: dict[str, bytes] = {}
    for model, start, _ in accepted_parameters(models, parameters or {}, own):
        reference = reference_files(model, start) if references else {}
        stop_time = stop_times.get(model, STOP_TIME)
        members = _members(model, start, fmi, targets, own.get(model), stop_time)
        inside = declared_inside(reference) if references else {}
        files[f"{model}.fmu"] = zipped({**members, **inside})
        files |= reference
    return write_into(folder, files)


def _members(
    model: str,
    start: Mapping[str, Value],
    fmi: int,
    targets: Sequence[Platform],
    own: Path | None,
    stop_time: float,
) -> dict[str, bytes]:
    """Return the files of one FMU."""
    in_c = model_in_c(model, start)
    layer = _LAYERS[fmi]
    sources = {name: (_C / name).read_bytes() for name in ("core.h", "core.c", layer[0])}
    for name in layer[1:]:  # some releases of FMPy have other line ends
        sources[name] = (HEADERS / name).read_text("utf-8").encode()
    sources["model.c"] = in_c.text.encode()
    about = production()
    about["generationTool"] = about["generationTool"].partition(" with ")[0]
    what = {**sources, "about": json.dumps([about, model, dict(start), stop_time]).encode()}
    token = f"{{{UUID(hex=digest_of(what)[:32])}}}"
    flags = " ".join(flag for flag in FLAGS if flag != "-w")
    sources["all.c"] = _ALL.format(model=model, flags=flags, token=token, layer=layer[0]).encode()
    picture = picture_file(model).read_bytes()
    described = (
        description3.description(model, start, in_c, about, token, stop_time)
        if fmi == 3
        else description(
            model, start, about, token, stop_time=stop_time, fixed=in_c.fixed, native=True
        )
    )
    members = {
        "modelDescription.xml": written(described),
        "documentation/index.html": page(
            model, dict(start), about["generationTool"], own, native=fmi, fixed=in_c.fixed
        ).encode(),
        "documentation/licenses/license.txt": (DOCUMENTATION / "license.txt").read_bytes(),
        "documentation/licenses/fmi_headers.txt": _licence(HEADERS / layer[1]),
        "model.png": picture,
    }
    if fmi == 3:
        sources["buildDescription.xml"] = description3.build_description(model, flags)
        members["terminalsAndIcons/terminalsAndIcons.xml"] = description3.terminals(model)
        members["terminalsAndIcons/icon.png"] = members.pop("model.png")
    for target, library in _binaries(sources, targets):
        members[f"binaries/{target.folder(fmi)}/{model}{target.suffix}"] = library
    return {**members, **{f"sources/{name}": text for name, text in sources.items()}}


def _binaries(
    sources: Mapping[str, bytes], targets: Sequence[Platform]
) -> Iterator[tuple[Platform, bytes]]:
    """Compile the sources for each platform."""
    with TemporaryDirectory() as work:
        for name, content in sources.items():
            Path(work, name).write_bytes(content)
        for target in targets:
            library = Path(work, f"{target.name}{target.suffix}")
            compiled(Path(work, "all.c"), library, target)
            yield target, library.read_bytes()


def _licence(header: Path) -> bytes:
    """Return the copyright notice of an FMI header."""
    text = header.read_text("utf-8")
    start = text.index("Copyright")
    end = text.index("*/", start)
    lines = [line.strip().removeprefix("*").strip() for line in text[start:end].splitlines()]
    return ("The FMI headers in sources/:\n\n" + "\n".join(lines).strip() + "\n").encode()
