"""Correct the Linux library that pythonfmu puts into every FMU, so that processes exit cleanly.

pythonfmu 0.7.0 finalises its interpreter twice when a process exits: first in the destructor of a
static `shared_ptr`, run by `exit`, then in `onLibraryUnload`, which the dynamic loader finds in
`DT_FINI_ARRAY` and which writes into the block that the destructor has freed. A few processes in a
hundred abort. (The loader does not unload the library earlier, because it defines unique symbols.)
With that entry removed from the array, only the destructor finalises the interpreter.
"""

from __future__ import annotations

import struct
from contextlib import suppress
from pathlib import Path
from struct import Struct
from typing import Any

# ELF for 64 bits, little-endian (System V ABI)
_IDENTITY = b"\x7fELF\x02\x01"
_HEADER = Struct("<40x Q 12x H 2x")  # where the section headers are, how many
_SECTION = Struct("<4x I 16x Q Q I 20x")  # type, where, size, link
_SYMBOL = Struct("<I 4x Q 8x")  # name, value
_RELOCATION = Struct("<Q 8x Q")  # place, addend
_DYNAMIC = Struct("<Q Q")  # tag, value
_SYMBOLS, _RELOCATIONS, _DYNAMICS = 2, 4, 6  # types of sections
_FINI_ARRAY, _FINI_ARRAYSZ = 26, 28  # dynamic tags
_POINTER = 8  # bytes

_SECOND_END = b"_ZN12_GLOBAL__N_115onLibraryUnloadEv"  # (anonymous namespace)::onLibraryUnload()


def ended_once(library: bytes) -> bytes:
    """Return the library without the function that finalises its interpreter a second time.

    Parameters
    ----------
    library : Linux library of an FMU packed by pythonfmu

    Returns
    -------
    The library with a `DT_FINI_ARRAYSZ` of 8 in place of 16 bytes; unchanged if on exit it calls only
    the compiler's function.

    Raises
    ------
    ValueError : not a 64-bit ELF library, or one that calls some other function on exit.
    """
    if not library.startswith(_IDENTITY):
        raise ValueError("it is not a 64-bit little-endian ELF library")
    try:
        return _ended_once(library)
    except (struct.error, LookupError, OverflowError) as error:
        raise ValueError("its sections cannot be read") from error


def _ended_once(library: bytes) -> bytes:
    first, count = _HEADER.unpack_from(library)
    sections = [_SECTION.unpack_from(library, first + k * _SECTION.size) for k in range(count)]

    def records(kind: int, layout: Struct) -> list[tuple[Any, ...]]:
        """Return the records in the sections of a type: link, offset, and the record's fields."""
        return [
            (link, at, *layout.unpack_from(library, at))
            for type_, start, size, link in sections
            if type_ == kind
            for at in range(start, start + size, layout.size)
        ]

    dynamic = {tag: (at, value) for _, at, tag, value in records(_DYNAMICS, _DYNAMIC)}
    at, size = dynamic.get(_FINI_ARRAYSZ, (0, 0))
    if size <= _POINTER:
        return library
    last = dynamic[_FINI_ARRAY][1] + size - _POINTER
    called = {what for _, _, place, what in records(_RELOCATIONS, _RELOCATION) if place == last}
    names = {
        library[sections[link][1] + name :].split(b"\0", 1)[0]
        for link, _, name, value in records(_SYMBOLS, _SYMBOL)
        if value in called
    }
    if size != 2 * _POINTER or _SECOND_END not in names:
        raise ValueError("it calls an unknown function on exit")
    return library[:at] + _DYNAMIC.pack(_FINI_ARRAYSZ, _POINTER) + library[at + _DYNAMIC.size :]


def mend_unpacked(fmu: Path) -> None:
    """Correct the libraries of an unpacked FMU of any origin; leave an unknown library unchanged."""
    for path in fmu.glob("binaries/*linux*/*.so"):
        library = path.read_bytes()
        with suppress(ValueError):
            if (mended := ended_once(library)) != library:
                path.write_bytes(mended)
