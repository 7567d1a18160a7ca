"""Expressions of the small language in C, with their types and effects."""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from phaseplane.suspension.kernel_types import NUMBERS
from phaseplane.suspension.trace import number

from .effects import ANY_ARRAY, effects
from .kernel_sources import Definition, Sources

_MATHS = (
    "fabs", "sqrt", "pow", "exp", "log", "log1p", "sin", "cos", "sinh", "cosh", "tanh", "floor", "ceil",
    "isfinite",
)  # fmt: skip
_CHOICES = {"min": "<", "max": ">"}
BINARY = {ast.Add: ("+", 11), ast.Sub: ("-", 11), ast.Mult: ("*", 12), ast.Div: ("/", 12),
           ast.FloorDiv: ("/", 12), ast.Mod: ("%", 12)}  # fmt: skip
COMPARED = {ast.Lt: ("<", 9), ast.LtE: ("<=", 9), ast.Gt: (">", 9), ast.GtE: (">=", 9),
             ast.Eq: ("==", 8), ast.NotEq: ("!=", 8)}  # fmt: skip
_UNARY, _PRIMARY, _AND, _OR, _EITHER = 13, 15, 5, 4, 3  # levels of precedence in C
INTEGERS = ("int", "bint", "long long", "Py_ssize_t")
_KEYWORDS = (
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum",
    "extern", "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return",
    "short", "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void",
    "volatile", "while",
)  # fmt: skip


class NotTranslatableError(ValueError):
    """A construct that is not in the small language; the message names file and line."""


@dataclass(frozen=True, slots=True)
class C:
    """An expression in C.

    Parameters
    ----------
    text : as written
    kind : its type as declared: `double`, `int`, `bint`, an array or a record
    level : precedence of its outermost operator
    reads, writes : names of the fields and arrays that its evaluation reads and writes
    """

    text: str
    kind: str
    level: int = _PRIMARY
    reads: frozenset[str] = frozenset()
    writes: frozenset[str] = frozenset()

    def within(self, level: int) -> str:
        """Return its text as an operand of an operator of this level."""
        return self.text if self.level >= level else f"({self.text})"

    @property
    def is_array(self) -> bool:
        return self.kind.endswith(("*", "]"))

    @property
    def item(self) -> str:
        """The type of the items of an array."""
        return re.sub(r"(\*|\[\d+\])$", "", self.kind)


class Expressions:
    """The expressions of one routine.

    Parameters
    ----------
    kernel : the sources
    definition : of the routine
    """

    def __init__(self, kernel: Sources, definition: Definition) -> None:
        self.kernel, self.definition = kernel, definition
        types = definition.types
        # of all local names; others follow from their first value
        self.kinds = dict(types.parameters)
        self.calls: set[tuple[str, str]] = set()
        self.changed: set[tuple[str, str]] = set()  # fields, by class and name
        self._loops: list[str] = []  # names of the loops around
        self._stale: set[str] = set()  # variables of loops that have ended: Python and C differ
        self._assigned: set[str] = set()

    def _wrong(self, node: ast.AST, why: str) -> NotTranslatableError:
        line = getattr(node, "lineno", self.definition.tree.lineno)
        where = f"{self.definition.path.name}, line {line}"
        what = ast.unparse(node) if isinstance(node, ast.expr | ast.stmt) else ""
        what = "" if isinstance(node, ast.FunctionDef) else f": {what.splitlines()[0]}"
        return NotTranslatableError(f"{where}, {self.definition.tree.name}{what}: {why}")

    @staticmethod
    def _name(name: str) -> str:
        return f"{name}_" if name in _KEYWORDS or re.fullmatch(r"end_\d+|kept_\d+", name) else name

    def _note_change(self, node: ast.expr) -> None:
        if isinstance(node, ast.Attribute):
            self.changed.add((self._record(node.value)[1], node.attr))

    def _as(self, kind: str, node: ast.expr) -> C:
        """Return an expression as a value of a type."""
        found = self._truth(node) if kind == "bint" else self._expression(node)
        if kind == "double" and found.kind in (kind, *INTEGERS):
            return found
        if kind in INTEGERS and found.kind in INTEGERS:
            return found
        if found.is_array and kind.endswith("*") and kind[:-1] == found.item:
            is_fixed = "->" not in found.text and found.text not in map(self._name, self.kinds)
            text = f"({NUMBERS[found.item]} *) {found.text}" if is_fixed else found.text
            return replace(found, text=text, kind=kind)
        records = self.kernel.records.keys() >= {kind, found.kind}
        if records and self.kernel.in_c(kind) == self.kernel.in_c(found.kind):
            return found
        raise self._wrong(node, f"a value of type {found.kind} where {kind} is wanted")

    def _truth(self, node: ast.expr) -> C:
        """Return an expression of which only the truth matters."""
        if isinstance(node, ast.BoolOp):
            sign, level = ("&&", _AND) if isinstance(node.op, ast.And) else ("||", _OR)
            parts = [self._truth(value) for value in node.values]
            # with brackets within `||`, as compilers advise
            texts = [p.within(level + 1 if level == _AND else _AND + 1) for p in parts]
            return self._joined(f" {sign} ".join(texts), "bint", level, parts)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            part = self._truth(node.operand)
            return self._joined(f"!{part.within(_UNARY)}", "bint", _UNARY, [part])
        found = self._expression(node)
        if found.kind not in NUMBERS:
            raise self._wrong(node, "only a number is true or false")
        return found

    def _expression(self, node: ast.expr) -> C:
        make = getattr(self, f"_of_{type(node).__name__.lower()}", None)
        if make is None:
            raise self._wrong(node, "this expression is not in the language")
        found = make(node)
        assert isinstance(found, C)
        return found

    def _joined(self, text: str, kind: str, level: int, parts: Sequence[C]) -> C:
        return C(
            text,
            kind,
            level,
            frozenset().union(*(p.reads for p in parts)),
            frozenset().union(*(p.writes for p in parts)),
        )

    def _compare_effects(self, node: ast.AST, parts: Sequence[C]) -> None:
        """Refuse parts of which one changes what another reads: C does not order them."""
        for k, part in enumerate(parts):
            for other in (*parts[:k], *parts[k + 1 :]):
                touched = other.reads | other.writes
                anywhere = (ANY_ARRAY in part.writes and touched) or (
                    ANY_ARRAY in touched and part.writes
                )
                if anywhere or part.writes & touched:
                    raise self._wrong(
                        node, "the order of evaluation matters here; use another statement"
                    )

    def _of_constant(self, node: ast.Constant) -> C:
        if isinstance(node.value, bool):
            return C(str(int(node.value)), "bint")
        if isinstance(node.value, int):
            return C(str(node.value), "int")
        if isinstance(node.value, float):
            return C(number(node.value), "double")
        raise self._wrong(node, "this constant is not in the language")

    def _of_name(self, node: ast.Name) -> C:
        name = node.id
        if name in self.kinds:
            given = name in self._assigned or name in self.definition.types.parameters
            if name not in self._loops and (name in self._stale or not given):
                raise self._wrong(node, f"{name} has no value here that C and Python agree on")
            return C(self._name(name), self.kinds[name])
        if name in self.kernel.constants:
            kind = "int" if isinstance(self.kernel.constants[name], int) else "double"
            return C(constant(name), kind)
        raise self._wrong(node, f"{name} is not declared")

    def _of_attribute(self, node: ast.Attribute) -> C:
        owner, held = self._record(node.value)
        fields = self.kernel.fields[held]
        if node.attr not in fields or not in_c(fields[node.attr], self.kernel):
            raise self._wrong(node, f"{held} has no field {node.attr} in C")
        if (held, node.attr) in self.kernel.fixed:
            return C(called(held, node.attr), fields[node.attr])
        return C(
            f"{owner.text}->{node.attr}", fields[node.attr], _PRIMARY, owner.reads | {node.attr}
        )

    def _record(self, node: ast.expr) -> tuple[C, str]:
        """Return an expression that is a record, and the name of that."""
        if isinstance(node, ast.Name) and node.id == "self":
            return C("self", self.definition.owner), self.definition.owner
        found = self._expression(node)
        if found.kind not in self.kernel.records:
            raise self._wrong(node, "this is not a record")
        return found, self.kernel.in_c(found.kind)

    def _of_subscript(self, node: ast.Subscript) -> C:
        array, index = self._expression(node.value), self._expression(node.slice)
        if not array.is_array or index.kind not in INTEGERS:
            raise self._wrong(node, "an array has one index, an integer")
        if isinstance(node.slice, ast.UnaryOp):
            raise self._wrong(node, "an index from the end")
        self._compare_effects(node, [array, index])
        reads = array.reads or frozenset({ANY_ARRAY})
        found = self._joined(f"{array.text}[{index.text}]", array.item, _PRIMARY, [array, index])
        return replace(found, reads=found.reads | reads)

    def _of_unaryop(self, node: ast.UnaryOp) -> C:
        if isinstance(node.op, ast.Not):
            return self._truth(node)
        if not isinstance(node.op, ast.USub):
            raise self._wrong(node, "this sign is not in the language")
        part = self._expression(node.operand)
        kind = "int" if part.kind == "bint" else part.kind
        if kind not in NUMBERS:
            raise self._wrong(node, "only a number has a sign")
        # above its own level, as C reads -- as another operator
        return replace(part, text=f"-{part.within(_PRIMARY)}", kind=kind, level=_UNARY)

    def _of_binop(self, node: ast.BinOp) -> C:
        if type(node.op) not in BINARY:
            raise self._wrong(node, "this operation is not in the language")
        sign, level = BINARY[type(node.op)]
        left, right = self._expression(node.left), self._expression(node.right)
        for part in (left, right):
            if part.kind not in NUMBERS:
                raise self._wrong(node, f"{part.text} is not a number")
        self._compare_effects(node, [left, right])
        integers = left.kind in INTEGERS and right.kind in INTEGERS
        if isinstance(node.op, ast.FloorDiv | ast.Mod) and not integers:
            raise self._wrong(node, "this operation is for integers")
        kind = "double"
        if integers and not isinstance(node.op, ast.Div):
            kind = next((k.kind for k in (left, right) if k.kind in INTEGERS[2:]), "int")
        first = left.within(level)
        if integers and isinstance(node.op, ast.Div):
            first = f"(double) {left.within(_UNARY)}"
        second = right.within(level + 1)
        return self._joined(f"{first} {sign} {second}", kind, level, [left, right])

    def _of_compare(self, node: ast.Compare) -> C:
        if len(node.ops) == 1 and isinstance(node.ops[0], ast.In | ast.NotIn):
            return self._among(node)
        if len(node.ops) == 1 and isinstance(node.ops[0], ast.Is | ast.IsNot):
            return self._absent(node)
        values = [self._expression(x) for x in (node.left, *node.comparators)]
        if any(v.kind not in NUMBERS for v in values):
            raise self._wrong(node, "only numbers are compared")
        self._compare_effects(node, values)
        if any(v.writes for v in values[1:-1]):
            raise self._wrong(node, "a call in the middle of a comparison")
        parts = []
        for op, left, right in zip(node.ops, values, values[1:], strict=False):
            if type(op) not in COMPARED:
                raise self._wrong(node, "this comparison is not in the language")
            sign, level = COMPARED[type(op)]
            text = f"{left.within(level + 2)} {sign} {right.within(level + 2)}"
            parts.append(self._joined(text, "bint", level, [left, right]))
        if len(parts) == 1:
            return parts[0]
        return self._joined(" && ".join(p.text for p in parts), "bint", _AND, parts)

    def _absent(self, node: ast.Compare) -> C:
        """Return whether a record is None."""
        none = node.comparators[0]
        found = self._expression(node.left)
        if found.kind not in self.kernel.records or ast.unparse(none) != "None":
            raise self._wrong(node, "only a record may be None")
        sign = "==" if isinstance(node.ops[0], ast.Is) else "!="
        return self._joined(f"{found.text} {sign} NULL", "bint", 8, [found])

    def _among(self, node: ast.Compare) -> C:
        choices, one = node.comparators[0], self._expression(node.left)
        written = choices.elts if isinstance(choices, ast.Tuple | ast.List | ast.Set) else []
        parts = [self._expression(choice) for choice in written]
        if not parts or any(part.writes for part in (one, *parts)):
            raise self._wrong(node, "a value may be one among written constants")
        is_in = isinstance(node.ops[0], ast.In)
        sign, join, level = ("==", " || ", _OR) if is_in else ("!=", " && ", _AND)
        text = join.join(f"{one.within(10)} {sign} {p.within(10)}" for p in parts)
        return self._joined(text, "bint", level if len(parts) > 1 else 8, [one, *parts])

    def _of_boolop(self, node: ast.BoolOp) -> C:
        parts = [self._expression(value) for value in node.values]
        if all(part.kind == "bint" for part in parts):
            return self._truth(node)
        if isinstance(node.op, ast.Or) or any(part.kind not in INTEGERS for part in parts):
            raise self._wrong(node, "as a value, `or` joins conditions only, `and` also integers")
        text = parts[-1].within(_EITHER)
        for part in reversed(parts[:-1]):
            text = f"{part.within(_EITHER + 1)} ? {text} : 0"
        return self._joined(text, "int", _EITHER, parts)

    def _of_ifexp(self, node: ast.IfExp) -> C:
        test = self._truth(node.test)
        yes, no = self._expression(node.body), self._expression(node.orelse)
        if yes.kind not in NUMBERS or no.kind not in NUMBERS:
            raise self._wrong(node, "only numbers are chosen between")
        kinds = {yes.kind, no.kind}
        kind = yes.kind if len(kinds) == 1 else "double" if "double" in kinds else "int"
        text = f"{test.within(_EITHER + 1)} ? {yes.within(_EITHER + 1)} : {no.within(_EITHER)}"
        return self._joined(text, kind, _EITHER, [test, yes, no])

    def _of_call(self, node: ast.Call) -> C:
        if node.keywords or any(isinstance(a, ast.Starred) for a in node.args):
            raise self._wrong(node, "arguments are given by position")
        if isinstance(node.func, ast.Attribute):
            owner, held = self._record(node.func.value)
            return self._call(node, (held, node.func.attr), [owner])
        if not isinstance(node.func, ast.Name):
            raise self._wrong(node, "this cannot be called")
        name = node.func.id
        if ("", name) in self.kernel.routines:
            return self._call(node, ("", name), [])
        if name in _MATHS:
            given = [self._as("double", argument) for argument in node.args]
            self._compare_effects(node, given)
            kind = "bint" if name == "isfinite" else "double"
            return self._joined(
                f"{name}({', '.join(g.text for g in given)})", kind, _PRIMARY, given
            )
        if name in _CHOICES:
            return self._choice(node, name)
        raise self._wrong(node, f"{name} is not in the language")

    def _choice(self, node: ast.Call, name: str) -> C:
        given = [self._expression(argument) for argument in node.args]
        if len(given) < 2:
            raise self._wrong(node, "the least or largest of at least two numbers")
        integers = all(g.kind in ("int", "bint") for g in given)
        if not integers and any(g.kind != "double" for g in given):
            raise self._wrong(node, "numbers of one type are compared")
        self._compare_effects(node, given)
        function = f"{name}_of{'_integers' if integers else ''}"
        text = given[0].text
        for other in given[1:]:
            text = f"{function}({text}, {other.text})"
        return self._joined(text, "int" if integers else "double", _PRIMARY, given)

    def _call(self, node: ast.Call, key: tuple[str, str], owner: list[C]) -> C:
        if self.kernel.calls_python(*key):
            return C("NAN", "double")  # of a function that only a host in Python can have
        if key not in self.kernel.routines:
            raise self._wrong(node, f"{key[1]} is no routine of the language")
        self.calls.add(key)
        types = self.kernel.routines[key].types
        if len(node.args) != len(types.parameters):
            raise self._wrong(node, f"{len(types.parameters)} arguments are wanted")
        kinds = types.parameters.values()
        given = [self._as(kind, a) for kind, a in zip(kinds, node.args, strict=True)]
        self._compare_effects(node, given)
        text = f"{called(*key)}({', '.join(g.text for g in (*owner, *given))})"
        own = effects(self.kernel)[key]
        for argument, c in zip(node.args, given, strict=True):
            if c.is_array and ANY_ARRAY in own.writes:
                self._note_change(argument)
        found = self._joined(text, types.returns, _PRIMARY, [*owner, *given])
        # what is passed is evaluated before the call; only what it does itself can clash with others
        return replace(found, reads=found.reads | own.reads, writes=found.writes | own.writes)


def constant(name: str) -> str:
    """Return the name of a constant in C, where names that begin with an underscore are reserved."""
    return name.lstrip("_")


def in_c(kind: str, kernel: Sources) -> bool:
    """Return whether a field of this type exists in C; lists and the like do not."""
    return kind.endswith(("*", "]")) or kind in NUMBERS or kind in kernel.records


def called(owner: str, name: str) -> str:
    """Return the name of a routine in C."""
    return f"{owner}_{name}" if owner else name
