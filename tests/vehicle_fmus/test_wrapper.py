"""pythonfmu's library for Linux: what is mended in it, what is let be, and what is refused."""

from __future__ import annotations

import zipfile
from contextlib import suppress
from importlib.resources import files
from pathlib import Path

import pytest
from hosting import compiled
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.vehicle_fmus import build as packing
from phaseplane.vehicle_fmus.build import build
from phaseplane.vehicle_fmus.wrapper import ended_once, mend_unpacked

PYTHONFMUS = files("pythonfmu").joinpath("resources/binaries/linux64/libpythonfmu-export.so")
FAULTY = PYTHONFMUS.read_bytes()
SECOND_END = "_ZN12_GLOBAL__N_115onLibraryUnloadEv"


def library(folder: Path, *functions: str, options: tuple[str, ...] = ()) -> bytes:
    """A library that calls functions of these names on exit."""
    source = folder / "library.c"
    called = '__attribute__((destructor)) static void {}(void) {{ __asm__(""); }}\n'
    source.write_text("int answer = 42;\n" + "".join(map(called.format, functions)))
    return compiled(source, folder / "library.so", "-shared", "-fPIC", *options).read_bytes()


def test_one_byte_is_mended() -> None:
    """Where this fails, pythonfmu has changed: see whether there is anything left to be mended."""
    mended = ended_once(FAULTY)
    changed = [(a, b) for a, b in zip(FAULTY, mended, strict=True) if a != b]
    assert changed == [(16, 8)]
    assert ended_once(mended) == mended


def test_a_library_without_the_fault_stays_as_it_is(tmp_path: Path) -> None:
    plain = library(tmp_path)
    assert ended_once(plain) == plain
    bare = library(tmp_path, options=("-nostartfiles",))
    assert ended_once(bare) == bare
    again = library(tmp_path, SECOND_END)
    assert len(ended_once(again)) == len(again)
    assert ended_once(again) != again


def test_what_is_not_known_is_refused(tmp_path: Path) -> None:
    other = library(tmp_path, "farewell")
    more = library(tmp_path, "farewell", SECOND_END)
    nameless = library(tmp_path, SECOND_END, options=("-s",))
    for unknown in (other, more, nameless):
        with pytest.raises(ValueError, match="calls an unknown function on exit"):
            ended_once(unknown)
    for no_library in (b"", b"MZ\x90", FAULTY[:5] + b"\x02" + FAULTY[6:]):
        with pytest.raises(ValueError, match="not a 64-bit little-endian ELF library"):
            ended_once(no_library)


@given(st.integers(0, len(FAULTY)), st.integers(0, 0x1000), st.binary(min_size=1, max_size=64))
def test_a_damaged_library_is_refused_or_keeps_its_length(end: int, at: int, noise: bytes) -> None:
    for damaged in (FAULTY[:end], FAULTY[:at] + noise + FAULTY[at + len(noise) :]):
        with suppress(ValueError):
            assert len(ended_once(damaged)) == len(damaged)


def test_a_pythonfmu_that_is_not_known_packs_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    unknown = library(tmp_path, "farewell")
    monkeypatch.setattr(packing, "ended_once", lambda _library: ended_once(unknown))
    with pytest.raises(RuntimeError, match=r"pythonfmu .* unknown function .* pythonfmu 0\.7\.0"):
        build(["Road"], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_what_is_packed_is_mended(fmus: dict[str, Path]) -> None:
    for model, file in fmus.items():
        with zipfile.ZipFile(file) as archive:
            assert archive.read(f"binaries/linux64/{model}.so") == ended_once(FAULTY)


def test_an_fmu_of_others_is_mended_where_it_is_unpacked(tmp_path: Path) -> None:
    contents = {
        "binaries/linux64/faulty.so": FAULTY,
        "binaries/x86_64-linux/faulty.so": FAULTY,  # where FMI 3.0 has it
        "binaries/linux64/unknown.so": library(tmp_path, "farewell"),
        "binaries/win64/faulty.so": FAULTY,
        "resources/faulty.so": FAULTY,
    }
    for name, content in contents.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(content)
    mend_unpacked(tmp_path)
    mended = {name for name in contents if (tmp_path / name).read_bytes() != contents[name]}
    assert mended == {"binaries/linux64/faulty.so", "binaries/x86_64-linux/faulty.so"}
