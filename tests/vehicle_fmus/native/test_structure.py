"""What one system fixes becomes constants in C, and nothing else does."""

from __future__ import annotations

import re
from array import array
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from phaseplane.vehicle_fmus.native.kernel_sources import Sources, sources
from phaseplane.vehicle_fmus.native.model import model_in_c
from phaseplane.vehicle_fmus.native.structure import specialised
from phaseplane.vehicle_fmus.native.translate import translated

MODULE = """
def fill(numbers: Doubles, count: int) -> None:
    for i in range(count):
        numbers[i] = 1.0

class Owner:
    count: int
    rate: float
    noted: float
    table: Doubles
    filled: Doubles
    written: Doubles
    first: Doubles
    second: Doubles
    reader: Reader

    def step(self) -> None:
        fill(self.filled, self.count)
        self.written[0] = self.table[self.count - 1] + self.rate + self.noted
        self.first, self.second = self.second, self.first
        for i in range(self.count):
            self.written[0] += self.table[i]
        self.reader.look()

class Reader:
    count: int
    seen: float
    shared: Doubles

    def look(self) -> None:
        self.seen = self.shared[self.count]
        self.count = 0
"""


@pytest.fixture
def kernel(tmp_path: Path) -> Sources:
    tmp_path.joinpath("module.py").write_text(MODULE)
    return sources(tmp_path)


def an_owner() -> Any:
    filled = array("d", [0.0, 0.0])
    reader = type("Reader", (SimpleNamespace,), {})(count=0, seen=0.0, shared=filled)
    return type("Owner", (SimpleNamespace,), {})(
        count=2, rate=0.5, noted=0.25, table=array("d", [3.0, 4.0]), filled=filled,
        written=array("d", [0.0]), first=array("d", [1.0]), second=array("d", [2.0]), reader=reader,
    )  # fmt: skip


def test_what_nothing_changes_is_constant(kernel: Sources) -> None:
    found = specialised(kernel, an_owner(), host="owner->noted = 1.0;")
    assert found.fixed == {
        ("Owner", "count"): 2,
        ("Owner", "rate"): 0.5,
        ("Owner", "table"): array("d", [3.0, 4.0]),
    }
    code = translated(found)
    assert "enum {\n    Owner_count = 2,\n};" in code
    assert "#define Owner_rate 0.5" in code
    assert "static const double Owner_table[2] = {\n    3.0, 4.0,\n};" in code
    assert "for (int i = 0; i < Owner_count; i++)" in code
    assert "Owner_table[Owner_count - 1] + Owner_rate + self->noted" in code


def test_arrays_of_one_owner_lie_in_its_record_and_others_stay_pointers(kernel: Sources) -> None:
    found = specialised(kernel, an_owner(), host="")
    assert found.lengths == {("Owner", "filled"): 2, ("Owner", "written"): 1}
    code = translated(found)
    assert "    double filled[2];" in code
    # one that is seen under two names is not constant under the one that nothing writes to
    assert "    double *shared;" in code
    assert "    double *first;" in code


def test_what_is_set_elsewhere_stays_a_pointer(kernel: Sources) -> None:
    owner = an_owner()
    found = specialised(kernel, owner, host="", free=[owner.table])
    assert ("Owner", "table") not in found.fixed
    assert ("Owner", "table") not in found.lengths


@pytest.fixture(scope="module")
def on_random_road() -> str:
    given: dict[str, Any] = {"road.shape": "random", "road.profile_length": 30.0}
    return model_in_c("QuarterCar", given).text


@pytest.mark.slow
def test_every_constant_of_a_model_is_used(on_random_road: str) -> None:
    folder = Path(model_in_c.__code__.co_filename).parent / "c"
    text = on_random_road + "".join(file.read_text() for file in folder.glob("*.c"))
    of_kernel, _, of_model = on_random_road.partition("};")
    defined = re.findall(r"^    (\w+) = ", of_kernel, re.M)
    defined += re.findall(r"^(?:#define|static const \w+) (\w+)", of_model, re.M)
    defined += re.findall(r"^typedef struct (\w+)", of_model, re.M)
    words = re.findall(r"\w+", re.sub(r"/\*.*?\*/", "", text, flags=re.S))
    assert [name for name in defined if words.count(name) < 2] == []


@pytest.mark.slow
def test_the_numbers_of_a_road_stand_once(on_random_road: str) -> None:
    long = re.findall(r"\d\.\d{15,}(?:e-\d+)?", on_random_road)
    repeated = {number for number in long if long.count(number) > 1}
    assert len(repeated) < 20 < len(set(long))
