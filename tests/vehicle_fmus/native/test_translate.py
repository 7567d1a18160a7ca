"""Each construct of the small language, in Python and in C; and what is not in it, refused."""

from __future__ import annotations

import ctypes
import math
import random
from array import array
from pathlib import Path
from typing import Any

import pytest
from hosting import library
from phaseplane.vehicle_fmus.native.kernel_sources import sources
from phaseplane.vehicle_fmus.native.translate import NotTranslatableError, translated

# of each construct the lines of a function of x, y, i, j (i and j from 0 to 5), and `numbers`, an array
# of eight
CONSTRUCTS = {
    "order of sums": "return x - (y - x) - y * (x + y) + (x + (y + 0.1))",
    "order of products": "return x * (y * 0.3) * x / (y * y + 1.0) / 7.0",
    "division of integers": "return (i + 1) / (j + 2) + x",
    "whole division": (
        "k = 3 * (7 * i // (j + 1)) * j\nm = 3 * (9 * i % (j + 1)) * j\nreturn k + 100 * m"
    ),
    "signs": "return -x - -y + -(-x * y) - -(i - 7) + -(-y)",
    "constants": "return 1e300 * x + 0.1 + _FACTOR * y + _COUNT",
    "maths": "return sqrt(fabs(x)) + exp(-y * y) + tanh(x) + log1p(x * x) + sin(x) * cos(y)",
    "more maths": "return floor(x) + ceil(y) + pow(fabs(x), 0.3) + sinh(y) + isfinite(x)",
    "least and largest": "return min(x, y) + max(x, y, 0.5) + min(i, j) + max(i, 2)",
    "zeros": "return min(0.0 * x, -0.0) + max(-0.0, 0.0)",
    "comparisons": "return 1.0 if x < y <= 1.5 or i == j != 3 else 2.0",
    "conditions": "return 1.0 if (x < y or i > j) and not (x > 0.5 and y > 0.5) else 2.0",
    "truth of numbers": "return 1.0 if x and i else 2.0",
    "nested choices": "return (x if x > y else y if i > 2 else 0.25) * (2.0 if x else 3.0)",
    "choices of both types": (
        "k = i if x > y else 2.5\nreturn k / 4 + numbers[i if x > y else j]"
    ),
    "one among": "return 1.0 if i in (1, _COUNT, 5) else 2.0 if j not in (0, 2) else 3.0",
    "integers that and joins": "k = i and j and i + 2\nreturn k",
    "loops": (
        "s = 0.0\nfor k in range(i):\n    for m in range(k, j + 3):\n"
        "        s = s * 0.7 + numbers[m] * x\nreturn s"
    ),
    "loops backwards": (
        "s = 0.0\nfor k in range(7, -1, -1):\n    s = s * y + numbers[k]\n"
        "for k in range(-3, 4, 2):\n    s += k * x\nreturn s"
    ),
    "a range is evaluated once": (
        "s = 0.0\nm = 3\nfor k in range(m):\n    m += i\n    s += x * m\nreturn s"
    ),
    "a name of loops and otherwise": (
        "s = 0.0\nfor k in range(4):\n    s += numbers[k]\nk = j\ns += numbers[k]\nreturn s"
    ),
    "while, break, continue": (
        "s = 0.0\nk = 0\nwhile True:\n    k += 1\n    if k == i:\n        continue\n"
        "    if k > 7:\n        break\n    s += x / k\nwhile k > j:\n    k -= 1\n    s *= y\nreturn s"
    ),
    "if, elif, else": (
        "if i == 0:\n    s = x\nelif i == 1:\n    s = y\nelif x > y:\n    s = 3.0\nelse:\n    s = 4.0\n"
        "return s"
    ),
    "several at once": "a, b = x, y\na, b = b, a + b\na, b = b, a\nreturn a - b",
    "items change places": (
        "numbers[i], numbers[j] = numbers[j], numbers[i]\nreturn numbers[i] * 3.0 + numbers[j]"
    ),
    "values through another name": "a = numbers\nnumbers[i], b = x, a[i]\nreturn b",
    "a chain": "numbers[i] = a = x * y\nreturn a + numbers[i] + numbers[j]",
    "changes in place": (
        "a = x\na += y\na -= 0.3\na *= y\na /= 1.7\nk = i\nk += 2\nk *= 3\nk -= j\nk //= 2\nk %= 5\n"
        "return a + k"
    ),
    "a name for an array": "a = numbers\na[i] = x\nreturn numbers[i] + a[j]",
    "calls": "return square(x) + square(y - x) * square(square(0.5))",
    "recursion": "return powers(x, i) + powers(y, j)",
    "C's own words": "short = x\nauto = i\nreturn short * auto",
    "a name for a value": "later = x * 0.5\nreturn later + y",
    "not a number": (
        "a = x * 1e308 * 10.0\na = a - a\nreturn max(a, 1.0) + (2.0 if a else 1.0)"
    ),
}  # fmt: skip
HELPERS = """
def square(x: float) -> float:
    \"\"\"Return x^2.\"\"\"
    return x * x

def powers(x: float, k: int) -> float:
    if k <= 0:
        return 1.0
    return x * powers(x, k - 1)
"""
GIVEN = "x: float, y: float, i: int, j: int, numbers: Doubles"


def written(folder: Path, functions: dict[str, str]) -> tuple[Path, dict[str, Any]]:
    """A module of functions, and the functions as Python has them."""
    source = ["from __future__ import annotations", "_FACTOR, _COUNT = 0.7, 3", HELPERS]
    for name, body in functions.items():
        lines = "\n".join(f"    {line}" for line in body.splitlines())
        source.append(f"def {name}({GIVEN}) -> float:\n{lines}\n")
    folder.joinpath("module.py").write_text("\n".join(source))
    names: dict[str, Any] = {**vars(math)}
    exec("\n".join(source), names)
    return folder, names


@pytest.fixture(scope="module")
def both(
    tmp_path_factory: pytest.TempPathFactory, compiler: str
) -> tuple[dict[str, Any], ctypes.CDLL]:
    folder = tmp_path_factory.mktemp("language")
    functions = {f"f{k}": what for k, what in enumerate(CONSTRUCTS.values())}
    folder, names = written(folder, functions)
    code = translated(sources(folder)).replace("static double", "double")
    flags = ["-Wall", "-Wextra", "-Werror", "-Wno-unused", "-Wno-missing-prototypes"]
    return names, library(code, folder, "-O2", *flags)


@pytest.mark.parametrize("what", CONSTRUCTS)
def test_each_construct_gives_the_same_bits(
    what: str, both: tuple[dict[str, Any], ctypes.CDLL]
) -> None:
    names, library = both
    function = f"f{list(CONSTRUCTS).index(what)}"
    compiled = library[function]
    compiled.restype = ctypes.c_double
    drawn = random.Random(what)
    for _ in range(50):
        x, y = drawn.uniform(-2.0, 2.0), drawn.choice([0.0, drawn.gauss(0.0, 1.0)])
        i, j = drawn.randrange(6), drawn.randrange(6)
        numbers = [drawn.gauss(0.0, 1.0) for _ in range(8)]
        here, there = array("d", numbers), (ctypes.c_double * 8)(*numbers)
        wanted = float(names[function](x, y, i, j, here))
        found = compiled(ctypes.c_double(x), ctypes.c_double(y), i, j, there)
        # hex: -0.0 is not 0.0, and nan is nan
        assert (found.hex(), [z.hex() for z in there]) == (wanted.hex(), [z.hex() for z in here])


REFUSED = {
    "a string": ("return 'x'", "this constant"),
    "a list": ("return [x][0]", "this expression"),
    "a power": ("return x**2", "this operation"),
    "an exception": ("raise ValueError(x)", "this statement"),
    "a try": ("try:\n    return x\nfinally:\n    pass", "this statement"),
    "a with": ("with x:\n    return y", "this statement"),
    "a loop over items": ("for a in numbers:\n    return a\nreturn x", "over a range"),
    "an else of a loop": ("for k in range(3):\n    pass\nelse:\n    x = y\nreturn x", "range"),
    "the variable of a loop after it": ("for k in range(3):\n    pass\nreturn k", "no value"),
    "the variable of a loop assigned": ("for k in range(3):\n    k = 1\nreturn x", "assigned"),
    "a step that is not known": ("for k in range(0, 9, i):\n    x += k\nreturn x", "written"),
    "a double for an integer": ("k = 0\nk = x\nreturn k", "double where int"),
    "a change before the first value": ("k += 1\nreturn k", "no value yet"),
    "a truth that becomes a number": ("k = x < y\nk = x\nreturn k", "double where bint"),
    "an unknown name": ("return z", "not declared"),
    "an unknown function": ("return len(numbers)", "not in the language"),
    "an argument too many": ("return square(x, y)", "1 arguments"),
    "a number for an array": ("return double(i)", "a value of type int where double\\* is wanted"),
    "an argument by name": ("return square(x=y)", "by position"),
    "a slice": ("a = numbers[1:]\nreturn x", "this expression"),
    "an index from the end": ("return numbers[-1]", "from the end"),
    "a field of a number": ("return x.real", "not a record"),
    "remainders of doubles": ("return x % y", "for integers"),
    "or as a value": ("k = i or j\nreturn k", "joins conditions only"),
    "no value at the end": ("if x > y:\n    return x", "without a value"),
    "a nested function": ("def g():\n    pass\nreturn x", "this statement"),
    "a lambda": ("return (lambda: x)()", "cannot be called"),
    "a comprehension": ("return max(z for z in numbers)", "this expression"),
    "an order that C leaves open": ("return double(numbers) + numbers[0]", "order of evaluation"),
    "an order among arguments": ("return pow(double(numbers), numbers[0])", "order of evaluation"),
    "an index of a number": ("return x[0]", "one index, an integer"),
    "an index that is no integer": ("return numbers[x]", "one index, an integer"),
    "the truth of an array": ("return 1.0 if numbers else 2.0", "only a number is true"),
    "a loop over what was no integer": ("k = x\nfor k in range(3):\n    pass\nreturn x", "before"),
    "a chain of types": ("k = 0\na = 0.0\na = k = i\nreturn a", "targets of different types"),
    "an inner loop before it": (
        "m = 1\nfor k in range(3):\n    x += m\n    for m in range(3):\n        pass\nreturn x",
        "no value",
    ),
    "a loop that need not assign": (
        "for k in range(3):\n    pass\nfor m in range(i):\n    k = j\nreturn k", "no value"
    ),
    "a change among several": ("return 1.0 if double(numbers) in (x, y) else 2.0", "constants"),
    "one among changes": ("return 1.0 if x in (y, double(numbers)) else 2.0", "written constants"),
    "an expression alone": ("x + y\nreturn x", "only a call"),
    "more names than values": ("a, b = numbers\nreturn a", "as many targets"),
}  # fmt: skip
CHANGING = (
    "\ndef double(numbers: Doubles) -> float:\n    numbers[0] *= 2.0\n    return numbers[0]\n"
)


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_not_in_the_language_is_refused_with_file_and_line(
    what: str, tmp_path: Path
) -> None:
    body, why = REFUSED[what]
    written(tmp_path, {"wrong": body})
    with tmp_path.joinpath("module.py").open("a") as file:
        file.write(CHANGING)
    with pytest.raises(NotTranslatableError, match=why) as refused:
        translated(sources(tmp_path))
    assert "module.py, line 1" in str(refused.value)


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("def f(x: complex) -> float:\n    return x", "line 1: complex is no type of the kernel"),
        ("class Some:\n    x: set\n    def f(self) -> float:\n        return 0.0", "line 2: set"),
        ("def f(*x: float) -> float:\n    return 0.0", "one by one"),
    ],
)
def test_types_and_parameters_that_c_does_not_have_are_refused(
    tmp_path: Path, body: str, why: str
) -> None:
    tmp_path.joinpath("module.py").write_text(body)
    with pytest.raises((ValueError, NotTranslatableError), match=why):
        translated(sources(tmp_path))
