"""The kernel's small language as readable C99: the same operations in the same order, so the same bits.

The language: methods and functions that their declarations call `nogil`, of numbers (double, int), arrays
of numbers and records of both; assignments, `if`, `while`, `for` over ranges, calls. There are no
objects, exceptions or strings. What is not in the language is refused with file and line.

For equal bits C must not contract (`-ffp-contract=off`) nor reorder (no `-ffast-math`). Where Python
fixes an order of evaluation that C leaves open, an expression in which it could matter is refused.
"""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from phaseplane.suspension.trace import number

from .declarations import NUMBERS
from .kernel_sources import Definition, Sources
from .statements import constants

_MATHS = (
    "fabs", "sqrt", "pow", "exp", "log", "log1p", "sin", "cos", "sinh", "cosh", "tanh", "floor", "ceil",
    "isfinite",
)  # fmt: skip
_CHOICES = {"min": "<", "max": ">"}
_BINARY = {ast.Add: ("+", 11), ast.Sub: ("-", 11), ast.Mult: ("*", 12), ast.Div: ("/", 12),
           ast.FloorDiv: ("/", 12), ast.Mod: ("%", 12)}  # fmt: skip
_COMPARED = {ast.Lt: ("<", 9), ast.LtE: ("<=", 9), ast.Gt: (">", 9), ast.GtE: (">=", 9),
             ast.Eq: ("==", 8), ast.NotEq: ("!=", 8)}  # fmt: skip
_UNARY, _PRIMARY, _AND, _OR, _EITHER = 13, 15, 5, 4, 3  # levels of precedence in C
_INTEGERS = ("int", "bint", "long long", "Py_ssize_t")
_WIDTH = 100
_KEYWORDS = (
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum",
    "extern", "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return",
    "short", "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void",
    "volatile", "while",
)  # fmt: skip
_ANY_ARRAY = "*"  # what a routine writes to through an array it was given


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


def needed(kernel: Sources, roots: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the routines that these call, and they themselves, in the order of the sources."""
    found: set[tuple[str, str]] = set()
    waiting = list(roots)
    while waiting:
        key = waiting.pop()
        if key not in found:
            found.add(key)
            waiting += _Routine(kernel, kernel.routines[key]).calls
    return [key for key in kernel.routines if key in found]


def translated(
    kernel: Sources,
    values: Mapping[str, int | float],
    routines: Sequence[tuple[str, str]] | None = None,
    host: str = "",
) -> str:
    """Return C for some routines, or for all: constants, records, prototypes and functions.

    Parameters
    ----------
    kernel : the sources
    values : the value of every constant
    routines : class in C and name of each; None for all
    host : C that is compiled with it, and may use the constants

    Raises
    ------
    NotTranslatableError : a construct that is not in the language.
    """
    chosen = list(kernel.routines) if routines is None else list(routines)
    bodies = [_Routine(kernel, kernel.routines[key]) for key in chosen]
    used = {word for text in (host, *(b.code for b in bodies)) for word in re.findall(r"\w+", text)}
    parts = [
        "#include <math.h>\n#include <stddef.h>\n",
        _constants(kernel, values, used),
        *_records(kernel, used),
        _CHOOSING,
        "\n".join(f"static {body.head};" for body in bodies) + "\n",
    ]
    owner = None
    for body in bodies:
        path = body.definition.path.name
        if path != owner:
            owner = path
            parts.append(f"/* ---- from {path} {'-' * (80 - len(path))} */\n")
        parts.append(body.text)
    return "\n".join(parts)


_CHOOSING = """\
static inline double min_of(double a, double b) { return b < a ? b : a; }
static inline double max_of(double a, double b) { return b > a ? b : a; }
static inline int min_of_integers(int a, int b) { return b < a ? b : a; }
static inline int max_of_integers(int a, int b) { return b > a ? b : a; }
"""


def _constants(kernel: Sources, values: Mapping[str, int | float], used: Collection[str]) -> str:
    """Return the definitions of the constants that are used, and of what one system fixes."""
    of_kernel = [(constant(name), k, values[name]) for name, k in kernel.constants.items()]
    fixed = [(called(*at), kernel.fields[at[0]][at[1]], x) for at, x in kernel.fixed.items()]
    lines, integers = [], []
    for name, kind, value in of_kernel + fixed:
        if name not in used:
            continue
        if kind.endswith("*"):
            texts = [in_digits(x, kind[:-1]) for x in value]
            lines.append(constants(name, texts or ["0"], NUMBERS[kind[:-1]]))
        elif kind == "double":
            lines.append(f"#define {name} {number(float(value))}")
        else:
            integers.append(f"    {name} = {int(value)},")
    enum = ["enum {", *integers, "};"] if integers else []  # one: members of two are not compared
    return "\n".join([*enum, *lines, ""])


def in_digits(value: float, kind: str) -> str:
    """Return a number of the kernel as a constant of this type."""
    return number(float(value)) if kind == "double" else str(int(value))


def constant(name: str) -> str:
    """Return the name of a constant in C, where names that begin with an underscore are reserved."""
    return name.lstrip("_")


def declared(name: str, kind: str, kernel: Sources) -> str:
    """Return the declaration of a field or variable in C."""
    if array := re.fullmatch(r"(\w+)\[(\d+)\]", kind):
        return f"{NUMBERS[array[1]]} {name}[{array[2]}]"
    if kind.endswith("*"):
        return f"{NUMBERS[kind[:-1]]} *{name}"
    if kind in NUMBERS:
        return f"{NUMBERS[kind]} {name}"
    return f"{kernel.in_c(kind)} *{name}"


def in_c(kind: str, kernel: Sources) -> bool:
    """Return whether a field of this type exists in C; lists and the like do not."""
    return kind.endswith(("*", "]")) or kind in NUMBERS or kind in kernel.records


def _records(kernel: Sources, used: Collection[str]) -> Iterator[str]:
    """Yield the definitions of the records that are used, and of those that they refer to."""
    waiting = [name for name in kernel.fields if name in used]
    names: set[str] = set()
    while waiting:
        name = waiting.pop()
        if name not in names:
            names.add(name)
            kinds = kernel.stored(name).values()
            waiting += [kernel.in_c(kind) for kind in kinds if kind in kernel.records]
    yield (
        "\n".join(f"typedef struct {name} {name};" for name in kernel.fields if name in names)
        + "\n"
    )
    for name in filter(names.__contains__, kernel.fields):
        lines = [
            f"    {declared(field, kind, kernel)};"
            for field, kind in kernel.stored(name).items()
            if in_c(kind, kernel)
        ]
        yield "\n".join([f"struct {name} {{", *(lines or ["    int unused;"]), "};\n"])


class _Routine:
    """One routine in C."""

    def __init__(self, kernel: Sources, definition: Definition) -> None:
        self.kernel, self.definition = kernel, definition
        types = definition.types
        self.kinds = {**types.parameters, **types.variables}  # of all local names
        self.calls: set[tuple[str, str]] = set()
        self.changed: set[tuple[str, str]] = set()  # fields, by class and name
        self.replaced: set[tuple[str, str]] = set()  # those that are arrays and become others
        self._depth = 0
        self._lines: list[str] = []
        self._hoisted = 0
        self._loops: list[str] = []  # names of the loops around
        found = list(ast.walk(definition.tree))
        loops = {n.target.id for n in found
                 if isinstance(n, ast.For) and isinstance(n.target, ast.Name)}  # fmt: skip
        others = {t.id for n in found if not isinstance(n, ast.For) for t in _targets(n)
                  if isinstance(t, ast.Name)}  # fmt: skip
        self._of_loops = loops - others  # variables of loops alone: they live in their loop
        self._stale: set[str] = set()  # variables of loops that have ended: Python and C differ
        self._assigned: set[str] = set()
        body = definition.tree.body
        if ast.get_docstring(definition.tree) is not None:
            body = body[1:]
        arguments = definition.tree.args
        named = [a.arg for a in arguments.args if a.arg != "self"]
        if named != list(types.parameters) or arguments.vararg or arguments.kwonlyargs:
            raise self._wrong(definition.tree, f"its parameters are not those declared: {named}")
        self._statements(body)
        if types.returns != "void" and not _ends(body):
            raise self._wrong(definition.tree, "it may end without a value")

    # -- the whole ---------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        return called(self.definition.owner, self.definition.types.name)

    @cached_property
    def head(self) -> str:
        types, owner = self.definition.types, self.definition.owner
        given = [f"{owner} *self"] if owner else []
        given += [self._declared(name, kind) for name, kind in types.parameters.items()]
        returns = "void" if types.returns == "void" else NUMBERS[types.returns]
        return f"{returns} {self.name}({', '.join(given) or 'void'})"

    @property
    def text(self) -> str:
        comment = ast.get_docstring(self.definition.tree) or ""
        lines = []
        if comment:
            inside = "\n".join(
                f" * {x}".rstrip() for x in comment.replace("*/", "* /").splitlines()
            )
            first = inside.removeprefix(" *").strip()
            lines.append(f"/* {first} */" if "\n" not in inside else f"/*\n{inside}\n */")
        return "\n".join([*lines, self.code])

    @cached_property
    def code(self) -> str:
        """The function without its comment."""
        head = _wrapped(f"static {self.head} {{")
        return "\n".join([*head, *self._local_declarations(), *self._lines, "}\n"])

    def _local_declarations(self) -> Iterator[str]:
        parameters = self.definition.types.parameters
        names = [n for n in self.kinds if n in self._assigned and n not in parameters]
        for kind in dict.fromkeys(self.kinds[n] for n in names):
            same = [self._name(n) for n in names if self.kinds[n] == kind]
            if kind.endswith("*"):
                yield from _wrapped(f"    {NUMBERS[kind[:-1]]} *{', *'.join(same)};")
            elif kind in NUMBERS:
                yield from _wrapped(f"    {NUMBERS[kind]} {', '.join(same)};")
            else:
                yield from _wrapped(f"    {self.kernel.in_c(kind)} *{', *'.join(same)};")

    def _declared(self, name: str, kind: str) -> str:
        if not in_c(kind, self.kernel):
            raise self._wrong(self.definition.tree, f"{name} is of type {kind}")
        return declared(self._name(name), kind, self.kernel)

    def _wrong(self, node: ast.AST, why: str) -> NotTranslatableError:
        line = getattr(node, "lineno", self.definition.tree.lineno)
        where = f"{self.definition.path.name}, line {line}"
        what = ast.unparse(node) if isinstance(node, ast.expr | ast.stmt) else ""
        what = "" if isinstance(node, ast.FunctionDef) else f": {what.splitlines()[0]}"
        return NotTranslatableError(f"{where}, {self.definition.tree.name}{what}: {why}")

    @staticmethod
    def _name(name: str) -> str:
        return f"{name}_" if name in _KEYWORDS or re.fullmatch(r"end_\d+|kept_\d+", name) else name

    # -- statements --------------------------------------------------------------------------------

    def _write(self, text: str) -> None:
        self._lines += _wrapped("    " * (self._depth + 1) + text)

    def _statements(self, body: Sequence[ast.stmt]) -> None:
        for statement in body:
            write = getattr(self, f"_{type(statement).__name__.lower()}", None)
            if write is None:
                raise self._wrong(statement, "this statement is not in the language")
            write(statement)

    def _block(self, body: Sequence[ast.stmt]) -> None:
        self._depth += 1
        self._statements(body)
        self._depth -= 1

    def _pass(self, node: ast.Pass) -> None:
        pass

    def _break(self, node: ast.Break) -> None:
        self._write("break;")

    def _continue(self, node: ast.Continue) -> None:
        self._write("continue;")

    def _return(self, node: ast.Return) -> None:
        wanted = self.definition.types.returns
        if node.value is None:
            if wanted != "void":
                raise self._wrong(node, "a value is missing")
            self._write("return;")
            return
        if wanted == "void":
            raise self._wrong(node, "nothing is to be returned")
        self._write(f"return {self._as(wanted, node.value).text};")

    def _expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Call):
            raise self._wrong(node, "only a call can stand alone")
        self._write(f"{self._expression(node.value).text};")

    def _if(self, node: ast.If, before: str = "") -> None:
        self._write(f"{before}if ({self._truth(node.test).text}) {{")
        stale = set(self._stale)
        self._block(node.body)
        after, self._stale = self._stale, stale
        self._else(node)
        self._stale |= after

    def _else(self, node: ast.If) -> None:
        if len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If):
            self._if(node.orelse[0], "} else ")
            return
        if node.orelse:
            self._write("} else {")
            self._block(node.orelse)
        self._write("}")

    def _while(self, node: ast.While) -> None:
        if node.orelse:
            raise self._wrong(node, "a loop has no else")
        always = isinstance(node.test, ast.Constant) and node.test.value is True
        self._write("for (;;) {" if always else f"while ({self._truth(node.test).text}) {{")
        self._repeated(node)
        self._write("}")

    def _repeated(self, node: ast.While | ast.For) -> None:
        """Write the body of a loop; what its own loops leave is stale in the next round."""
        inner = {n.target.id for x in node.body for n in ast.walk(x)
                 if isinstance(n, ast.For) and isinstance(n.target, ast.Name)}  # fmt: skip
        before = set(self._stale)
        self._stale |= inner
        self._block(node.body)
        self._stale |= before

    def _for(self, node: ast.For) -> None:
        call = node.iter
        is_range = (
            isinstance(call, ast.Call)
            and isinstance(call.func, ast.Name)
            and call.func.id == "range"
            and not call.keywords
        )
        if not (is_range and isinstance(node.target, ast.Name) and not node.orelse):
            raise self._wrong(node, "a loop goes over a range")
        assert isinstance(call, ast.Call)
        name = node.target.id
        kind = self.kinds.get(name, "")
        if kind not in _INTEGERS:
            raise self._wrong(node, f"{name} must be declared as int")
        if name in self._loops:
            raise self._wrong(node, f"{name} is the variable of a loop around")
        given = [self._as(kind, x) for x in call.args]
        step = _whole_number(call.args[2]) if len(given) == 3 else 1
        if not step:
            raise self._wrong(node, "the step of a range must be a written number")
        start, end = (given[0].text, given[1]) if len(given) > 1 else ("0", given[0])
        last = end.within(_COMPARED[ast.Lt][1] + 1)
        if not self._stays(call.args[min(1, len(given) - 1)], node.body):
            self._hoisted += 1
            last = f"end_{self._hoisted}"  # a range is evaluated once
            self._write(f"const {NUMBERS[kind]} {last} = {end.text};")
        i, compare = self._name(name), "<" if step > 0 else ">"
        change = {1: f"{i}++", -1: f"{i}--"}.get(step, f"{i} += {step}")
        new = f"{NUMBERS[kind]} " if name in self._of_loops else ""
        if not new:
            self._assigned.add(name)
            self._stale.discard(name)
        self._write(f"for ({new}{i} = {start}; {i} {compare} {last}; {change}) {{")
        self._loops.append(name)
        self._repeated(node)
        self._loops.pop()
        self._stale.add(name)
        self._write("}")

    def _stays(self, bound: ast.expr, body: Sequence[ast.stmt]) -> bool:
        """Return whether a bound cannot change while the loop runs."""
        assigned = {
            target.id
            for statement in body
            for child in ast.walk(statement)
            for target in _targets(child)
            if isinstance(target, ast.Name)
        }
        for node in ast.walk(bound):
            if isinstance(node, ast.Name) and node.id in assigned:
                return False
            if (
                isinstance(node, ast.Attribute)
                and node.attr in _written(self.kernel)
                and (self._record(node.value)[1], node.attr) not in self.kernel.fixed
            ):
                return False
            if isinstance(node, ast.Call | ast.IfExp):
                return False
        return True

    # -- assignments -------------------------------------------------------------------------------

    def _assign(self, node: ast.Assign) -> None:
        if isinstance(node.targets[0], ast.Tuple):
            self._assign_several(node)
            return
        value, targets = node.value, []
        for target in node.targets:
            found, value_as = self._target(target, value)
            targets.append(found)
        kinds = {t.kind.replace("bint", "int") for t in targets}
        if len(kinds) > 1 and not isinstance(value, ast.Constant):
            raise self._wrong(node, "targets of different types")
        text = " = ".join([*(t.text for t in targets), value_as.text])
        self._compare_effects(node, [value_as, *targets])
        self._write(f"{text};")

    def _assign_several(self, node: ast.Assign) -> None:
        target, value = node.targets[0], node.value
        same = isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)
        if not (same and len(node.targets) == 1):
            raise self._wrong(node, "several values are assigned to as many targets")
        assert isinstance(target, ast.Tuple)
        assert isinstance(value, ast.Tuple)
        if len(target.elts) != len(value.elts):
            raise self._wrong(node, "several values are assigned to as many targets")
        pairs = [self._target(t, v) for t, v in zip(target.elts, value.elts, strict=True)]
        for k, (_, later) in enumerate(pairs):
            if later.writes:
                raise self._wrong(node, "a call that changes something, among several values")
            before = {_root(t.text) for t, _ in pairs[:k]}
            memory = any(not t.text.isidentifier() for t, _ in pairs[:k])
            names = {n.id for n in ast.walk(value.elts[k]) if isinstance(n, ast.Name)}
            touches = names & before or (memory and later.reads and not later.is_array)
            if touches:
                break
        else:
            for found, given in pairs:
                self._write(f"{found.text} = {given.text};")
            return
        self._write("{")  # all values are found before the first is assigned
        self._depth += 1
        for k, (found, given) in enumerate(pairs):
            kind = f"{NUMBERS[given.item]} *" if given.is_array else f"{NUMBERS[found.kind]} "
            self._write(f"const {kind}kept_{k} = {given.text};")
        for k, (found, _) in enumerate(pairs):
            self._write(f"{found.text} = kept_{k};")
        self._depth -= 1
        self._write("}")

    def _augassign(self, node: ast.AugAssign) -> None:
        target, value = self._target(node.target, None)[0], self._expression(node.value)
        sign = _BINARY.get(type(node.op), ("", 0))[0]
        integer = target.kind in _INTEGERS
        ok = sign and (value.kind in _INTEGERS if integer else value.kind in NUMBERS)
        if not ok or (integer and isinstance(node.op, ast.Div)):
            raise self._wrong(node, "this operation is not in the language")
        if not integer and isinstance(node.op, ast.FloorDiv | ast.Mod):
            raise self._wrong(node, "this operation is for integers")
        self._compare_effects(node, [target, value])
        self._write(f"{target.text} {sign}= {value.text};")

    def _target(self, node: ast.expr, value: ast.expr | None) -> tuple[C, C]:
        """Return a target, and the value as one of its type."""
        if isinstance(node, ast.Name):
            if node.id in self._loops:
                raise self._wrong(node, "the variable of a loop is assigned")
            if node.id not in self.kinds:
                # declared nowhere: a double, as for the compiler of the kernel
                found = self._expression(value) if value is not None else None
                if found is None or found.kind != "double":
                    raise self._wrong(node, "its type is not declared")
                self.kinds[node.id] = "double"
            if node.id not in self.definition.types.parameters:
                self._assigned.add(node.id)
            self._stale.discard(node.id)
            target = C(self._name(node.id), self.kinds[node.id])
            if target.kind in self.kernel.records:
                raise self._wrong(node, "a record has one owner; it cannot be assigned")
        elif isinstance(node, ast.Attribute | ast.Subscript):
            target = self._expression(node)
            self._note_change(node.value if isinstance(node, ast.Subscript) else node)
            if isinstance(node, ast.Attribute) and target.is_array:
                self.replaced.add((self._record(node.value)[1], node.attr))
        else:
            raise self._wrong(node, "this cannot be assigned to")
        if value is not None and target.is_array:
            self._note_change(value)  # through the other name
        return target, target if value is None else self._as(target.kind, value)

    def _note_change(self, node: ast.expr) -> None:
        if isinstance(node, ast.Attribute):
            self.changed.add((self._record(node.value)[1], node.attr))

    # -- expressions -------------------------------------------------------------------------------

    def _as(self, kind: str, node: ast.expr) -> C:
        """Return an expression as a value of a type."""
        if kind == "bint":
            return self._truth(node)
        found = self._expression(node)
        if kind == "double" and found.kind in (kind, *_INTEGERS):
            return found
        if kind in _INTEGERS and found.kind in _INTEGERS:
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

    def _joined(self, text: str, kind: str, level: int, parts: Iterable[C]) -> C:
        parts = list(parts)
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
                anywhere = (_ANY_ARRAY in part.writes and touched) or (
                    _ANY_ARRAY in touched and part.writes
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
            return C(constant(name), self.kernel.constants[name])
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
        if not array.is_array or index.kind not in _INTEGERS:
            raise self._wrong(node, "an array has one index, an integer")
        if isinstance(node.slice, ast.UnaryOp):
            raise self._wrong(node, "an index from the end")
        self._compare_effects(node, [array, index])
        reads = array.reads or frozenset({_ANY_ARRAY})
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
        text = part.within(_UNARY)
        return replace(part, text=f"-({text})" if text[0] == "-" else f"-{text}", kind=kind,
                       level=_UNARY)  # fmt: skip

    def _of_binop(self, node: ast.BinOp) -> C:
        if type(node.op) not in _BINARY:
            raise self._wrong(node, "this operation is not in the language")
        sign, level = _BINARY[type(node.op)]
        left, right = self._expression(node.left), self._expression(node.right)
        for part in (left, right):
            if part.kind not in NUMBERS:
                raise self._wrong(node, f"{part.text} is not a number")
        self._compare_effects(node, [left, right])
        integers = left.kind in _INTEGERS and right.kind in _INTEGERS
        if isinstance(node.op, ast.FloorDiv | ast.Mod) and not integers:
            raise self._wrong(node, "this operation is for integers")
        kind = "double"
        if integers and not isinstance(node.op, ast.Div):
            kind = next((k.kind for k in (left, right) if k.kind in _INTEGERS[2:]), "int")
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
            if type(op) not in _COMPARED:
                raise self._wrong(node, "this comparison is not in the language")
            sign, level = _COMPARED[type(op)]
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
        if not isinstance(choices, ast.Tuple | ast.List | ast.Set) or one.writes:
            raise self._wrong(node, "a value may be one among written constants")
        parts = [self._expression(choice) for choice in choices.elts]
        is_in = isinstance(node.ops[0], ast.In)
        sign, join, level = ("==", " || ", _OR) if is_in else ("!=", " && ", _AND)
        text = join.join(f"{one.within(10)} {sign} {p.within(10)}" for p in parts)
        return self._joined(text, "bint", level if len(parts) > 1 else 8, [one, *parts])

    def _of_boolop(self, node: ast.BoolOp) -> C:
        parts = [self._expression(value) for value in node.values]
        if all(part.kind == "bint" for part in parts):
            return self._truth(node)
        if isinstance(node.op, ast.Or) or any(part.kind not in _INTEGERS for part in parts):
            raise self._wrong(node, "as a value, `or` joins conditions only, `and` also integers")
        text = parts[-1].within(_EITHER)
        for part in reversed(parts[:-1]):
            text = f"{part.within(_EITHER + 1)} ? {text} : 0"
        return self._joined(text, "int", _EITHER, parts)

    def _of_ifexp(self, node: ast.IfExp) -> C:
        test, yes, no = self._truth(node.test), self._expression(node.body), None
        no = self._expression(node.orelse)
        if yes.kind not in NUMBERS or no.kind not in NUMBERS:
            raise self._wrong(node, "only numbers are chosen between")
        kinds = {yes.kind, no.kind}
        kind = yes.kind if len(kinds) == 1 else "double" if "double" in kinds else "int"
        text = f"{test.within(_EITHER + 1)} ? {yes.within(_EITHER + 1)} : {no.within(_EITHER)}"
        return self._joined(text, kind, _EITHER, [test, yes, no])

    # -- calls -------------------------------------------------------------------------------------

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
        effects = _effects(self.kernel)[key]
        for argument, c in zip(node.args, given, strict=True):
            if c.is_array and _ANY_ARRAY in effects.writes:
                self._note_change(argument)
        found = self._joined(text, types.returns, _PRIMARY, [*owner, *given])
        # what is passed is evaluated before the call; only what it does itself can clash with others
        return replace(
            found, reads=found.reads | effects.reads, writes=found.writes | effects.writes
        )


def called(owner: str, name: str) -> str:
    """Return the name of a routine in C."""
    return f"{owner}_{name}" if owner else name


def _wrapped(line: str) -> list[str]:
    """Break a long line where there is a space; C does not mind."""
    if len(line) <= _WIDTH:
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    return textwrap.wrap(
        line.strip(), _WIDTH, initial_indent=indent, subsequent_indent=f"{indent}        ",
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


def _root(text: str) -> str:
    return re.split(r"\W", text, maxsplit=1)[0]


def _ends(body: Sequence[ast.stmt]) -> bool:
    """Return whether a block always ends with a value."""
    last = body[-1]
    if isinstance(last, ast.Return):
        return True
    if isinstance(last, ast.If):
        return bool(last.orelse) and _ends(last.body) and _ends(last.orelse)
    if isinstance(last, ast.While):
        always = isinstance(last.test, ast.Constant) and last.test.value is True
        return always and not any(isinstance(n, ast.Break) for n in ast.walk(last))
    return False


# -- what routines change --------------------------------------------------------------------------


def changed(kernel: Sources) -> tuple[set[tuple[str, str]], set[tuple[str, str]]]:
    """Return the fields, by class and name, that routines change; and arrays that are replaced."""
    found = [_Routine(kernel, definition) for definition in kernel.routines.values()]
    return set().union(*(r.changed for r in found)), set().union(*(r.replaced for r in found))


@dataclass(frozen=True, slots=True)
class _Effects:
    reads: frozenset[str]
    writes: frozenset[str]


def _targets(node: ast.AST) -> list[ast.expr]:
    match node:
        case ast.Assign():
            found = node.targets
        case ast.AugAssign() | ast.AnnAssign() | ast.For():
            found = [node.target]
        case _:
            return []
    return [x for t in found for x in (t.elts if isinstance(t, ast.Tuple) else [t])]


def _effects(kernel: Sources) -> dict[tuple[str, str], _Effects]:
    """Return the fields that every routine reads and writes, also through those that it calls."""
    return _once(kernel, "effects", _find_effects)  # type: ignore[return-value]


def _written(kernel: Sources) -> frozenset[str]:
    """Return the names of all fields that any routine writes."""
    return frozenset().union(*(e.writes for e in _effects(kernel).values()))


_KNOWN: dict[tuple[int, str], tuple[Sources, object]] = {}


def _once(kernel: Sources, what: str, make: object) -> object:
    key = id(kernel), what
    if key not in _KNOWN:
        _KNOWN[key] = kernel, make(kernel)  # type: ignore[operator]
    return _KNOWN[key][1]


def _find_effects(kernel: Sources) -> dict[tuple[str, str], _Effects]:
    own: dict[tuple[str, str], _Effects] = {}
    calls: dict[tuple[str, str], set[str]] = {}
    for key, definition in kernel.routines.items():
        reads, writes, names = set(), set(), set()
        held_by = _aliases(definition.tree)
        for node in ast.walk(definition.tree):
            if isinstance(node, ast.Attribute):
                reads.add(node.attr)
            if isinstance(node, ast.Call):
                names.add(
                    node.func.attr
                    if isinstance(node.func, ast.Attribute)
                    else ast.unparse(node.func)
                )
            for target in _targets(node):
                held = target.value if isinstance(target, ast.Subscript) else target
                if isinstance(held, ast.Attribute):
                    writes.add(held.attr)
                elif isinstance(target, ast.Subscript):
                    writes |= held_by.get(ast.unparse(held), {_ANY_ARRAY})
        own[key] = _Effects(frozenset(reads), frozenset(writes))
        calls[key] = names
    named: dict[str, list[tuple[str, str]]] = {}
    for key in own:
        named.setdefault(key[1], []).append(key)
    while True:
        new = {
            key: _Effects(
                effects.reads.union(*(own[k].reads for n in calls[key] for k in named.get(n, ()))),
                effects.writes.union(
                    *(own[k].writes for n in calls[key] for k in named.get(n, ()))
                ),
            )
            for key, effects in own.items()
        }
        if new == own:
            return own
        own = new


def _aliases(tree: ast.FunctionDef) -> dict[str, set[str]]:
    """Return the fields whose arrays local names stand for."""
    found: dict[str, set[str]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            target, value = node.targets[0], node.value
            pairs = [(target, value)]
            if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
                pairs = list(zip(target.elts, value.elts, strict=False))
            for name, given in pairs:
                if isinstance(name, ast.Name):
                    held = given.attr if isinstance(given, ast.Attribute) else _ANY_ARRAY
                    found.setdefault(name.id, set()).add(held)
    return found


def _whole_number(node: ast.expr) -> int:
    """Return a number as written, with its sign; 0 if it is none."""
    try:
        value = ast.literal_eval(node)
    except ValueError:
        return 0
    return value if isinstance(value, int) else 0


def check(folder: Path) -> list[str]:
    """Return what in a kernel is not in the small language, one sentence each."""
    from .kernel_sources import sources  # noqa: PLC0415

    found: dict[str, None] = {}
    for used in sources(folder).alternatives or ("",):
        kernel = sources(folder, [used])
        for definition in kernel.routines.values():
            try:
                _Routine(kernel, definition)
            except NotTranslatableError as error:
                found[str(error)] = None
    return list(found)
