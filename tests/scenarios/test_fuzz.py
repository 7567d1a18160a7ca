"""Mutated scene files: never a traceback, never a hang, never a file left half written.

Whatever the file has become, it is read, or refused in one line; what is read and small is also run, in
the process, and either comes to its end or says why not.
"""

from __future__ import annotations

import random
import re
from contextlib import suppress
from pathlib import Path

import pytest
from hosting import at_most
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.scene.names import CASES
from phaseplane.suspension.session import Session, SimulationError
from phaseplane.suspension.variables import MODELS

SEEDS = sorted(CASES.glob("*.toml"))
WORDS = (
    "nan", "inf", "-inf", "1e308", "-1e-320", "0", "-1", "true", '""', "[]", "{}", '"1 km/h"',
    '"3 parsec"',
    "99999999999999999999", '"\\u0000"', "[[", "]]", "#", "=", ".", '"ap57"', "1979-05-27", '"x:y, 1:2"',
    "[1, [2, [3]]]", "'''", "\x00", "\N{SNOWMAN}", "extends", "fmu", "road.shape", "expect.during",
)  # fmt: skip
HANG = 20.0  # s of the processor: far more than any scene needs to be read


def mutated(text: str, dice: random.Random) -> str:
    """The text with one to six small injuries."""
    for _ in range(dice.randint(1, 6)):
        at = dice.randrange(len(text) + 1)
        kind = dice.randrange(7)
        if kind == 0:  # a character flipped
            text = text[:at] + chr(dice.randrange(1, 0x250)) + text[at + 1 :]
        elif kind == 1:  # a stretch gone
            text = text[:at] + text[at + dice.randrange(30) :]
        elif kind == 2:  # a word put in
            text = text[:at] + dice.choice(WORDS) + text[at:]
        elif kind == 3:  # a value replaced
            lines = text.splitlines()
            row = dice.randrange(len(lines) or 1)
            if lines and "=" in lines[row]:
                lines[row] = f"{lines[row].split('=')[0]}= {dice.choice(WORDS)}"
            text = "\n".join(lines)
        elif kind == 4:  # a line of another case
            other = dice.choice(SEEDS).read_text(encoding="utf-8").splitlines()
            text = f"{text}\n{dice.choice(other)}"
        elif kind == 5:  # a number scaled
            factor = 10.0 ** dice.randint(-12, 12)
            found = re.search(r"\d+\.?\d*", text)
            if found:
                scaled = repr(float(found.group()) * factor)
                text = text[: found.start()] + scaled + text[found.end() :]
        else:  # lines in another order
            lines = text.splitlines()
            dice.shuffle(lines)
            text = "\n".join(lines)
    return text


def tried(seed: int, folder: Path) -> bool:
    """Read one mutated file, and run it a little if it can be read; whether it could."""
    dice = random.Random(seed)
    file = folder / "scene.toml"
    text = mutated(dice.choice(SEEDS).read_text(encoding="utf-8"), dice)
    file.write_text(text, encoding="utf-8", errors="surrogatepass")
    with at_most(HANG):
        try:
            scene = load_scene(str(file))
        except InputError as error:
            told = str(error)
            assert told.isprintable(), (seed, told)
            assert len(told) < 1000, (seed, told)
            return False
        if scene.fmu.model in MODELS and scene.fmu.path is None:
            with suppress(SimulationError):
                Session(scene.fmu.model, scene.parameters).advance(min(scene.duration, 1e-3))
        assert [path.name for path in folder.iterdir()] == ["scene.toml"]
        return True


@pytest.mark.parametrize("block", range(4))
def test_mutated_scenes_are_read_or_refused_in_one_line(tmp_path: Path, block: int) -> None:
    read = sum(tried(seed, tmp_path) for seed in range(100 * block, 100 * (block + 1)))
    assert 0 < read < 100  # both happen


@pytest.mark.slow
def test_ten_thousand_mutated_scenes(tmp_path: Path) -> None:
    read = sum(tried(seed, tmp_path) for seed in range(1000, 11000))
    assert 500 < read < 9500
