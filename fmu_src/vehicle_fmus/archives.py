"""Reproducible zip archives, and sets of files that are written completely or not at all."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from contextlib import suppress
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from secrets import token_hex

_NO_TIME = (1980, 1, 1, 0, 0, 0)  # the earliest that a zip archive can hold


def digest(*parts: bytes) -> str:
    """Return a hash of the parts, their lengths and their order."""
    total = sha256()
    for part in parts:
        total.update(len(part).to_bytes(8, "big"))
        total.update(part)
    return total.hexdigest()


def digest_of(members: Mapping[str, bytes]) -> str:
    """Return a hash of named contents."""
    return digest(*(part for name in sorted(members) for part in (name.encode(), members[name])))


def zipped(members: Mapping[str, bytes]) -> bytes:
    """Return a zip archive of named contents; equal contents give equal archives."""
    buffer = BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(members):
            entry = zipfile.ZipInfo(name, _NO_TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix, on every system
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, members[name])
    return buffer.getvalue()


def write_into(folder: Path, files: Mapping[str, bytes]) -> list[Path]:
    """Write all files to a folder, created if it is missing, or none; return their paths."""
    folder = Path(folder)
    made = [path for path in (folder, *folder.parents) if not path.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    contents = {folder / name: content for name, content in files.items()}
    try:
        write_all(contents)
    except BaseException:
        for path in made:
            with suppress(OSError):  # another program has written to it
                path.rmdir()
        raise
    return list(contents)


def write_all(contents: Mapping[Path, bytes]) -> None:
    """Write all files beside their targets, then move them into place."""
    written: dict[Path, Path] = {}
    try:
        for target, content in contents.items():
            written[target] = target.with_name(f".{token_hex(8)}.part")
            written[target].write_bytes(content)
        for target, part in written.items():
            part.replace(target)
    finally:
        for part in written.values():
            part.unlink(missing_ok=True)
