"""A routine of the small language as a function in C: its head, its variables and statements."""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Iterator, Sequence
from functools import cached_property

from phaseplane.suspension.kernel_types import NUMBERS

from .effects import targets, written_anywhere
from .expressions import (
    BINARY,
    COMPARED,
    INTEGERS,
    C,
    Expressions,
    called,
    in_c,
)
from .kernel_sources import Definition, Sources

_WIDTH = 100


class Routine(Expressions):
    """One routine in C."""

    def __init__(self, kernel: Sources, definition: Definition) -> None:
        super().__init__(kernel, definition)
        types = definition.types
        self.replaced: set[tuple[str, str]] = set()  # those that are arrays and become others
        self._depth = 0
        self._lines: list[str] = []
        self._hoisted = 0
        found = list(ast.walk(definition.tree))
        loops = {n.target.id for n in found
                 if isinstance(n, ast.For) and isinstance(n.target, ast.Name)}  # fmt: skip
        others = {t.id for n in found if not isinstance(n, ast.For) for t in targets(n)
                  if isinstance(t, ast.Name)}  # fmt: skip
        self._of_loops = loops - others  # variables of loops alone: they live in their loop
        body = definition.tree.body
        if ast.get_docstring(definition.tree) is not None:
            body = body[1:]
        arguments = definition.tree.args
        if arguments.vararg or arguments.kwonlyargs or arguments.kwarg or arguments.posonlyargs:
            raise self._wrong(definition.tree, "its parameters are given by position, one by one")
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
            yield from _wrapped(f"    {declared(kind, self.kernel, *same)};")

    def _declared(self, name: str, kind: str) -> str:
        if not in_c(kind, self.kernel):
            raise self._wrong(self.definition.tree, f"{name} is of type {kind}")
        return declared(kind, self.kernel, self._name(name))

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
        self._write(f"while ({self._truth(node.test).text}) {{")
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
        kind = self.kinds.setdefault(name, "int")
        if kind not in INTEGERS:
            raise self._wrong(node, f"{name} is no integer before")
        if name in self._loops:
            raise self._wrong(node, f"{name} is the variable of a loop around")
        given = [self._as(kind, x) for x in call.args]
        step = _whole_number(call.args[2]) if len(given) == 3 else 1
        if not step:
            raise self._wrong(node, "the step of a range must be a written number")
        start, end = (given[0].text, given[1]) if len(given) > 1 else ("0", given[0])
        last = end.within(COMPARED[ast.Lt][1] + 1)
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
            for target in targets(child)
            if isinstance(target, ast.Name)
        }
        for node in ast.walk(bound):
            if isinstance(node, ast.Name) and node.id in assigned:
                return False
            if (
                isinstance(node, ast.Attribute)
                and node.attr in written_anywhere(self.kernel)
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
            self._write(f"{kind}const kept_{k} = {given.text};")
        for k, (found, _) in enumerate(pairs):
            self._write(f"{found.text} = kept_{k};")
        self._depth -= 1
        self._write("}")

    def _augassign(self, node: ast.AugAssign) -> None:
        target, value = self._target(node.target, None)[0], self._expression(node.value)
        sign = BINARY.get(type(node.op), ("", 0))[0]
        integer = target.kind in INTEGERS
        ok = sign and (value.kind in INTEGERS if integer else value.kind in NUMBERS)
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
                self.kinds[node.id] = self._kind_of(node, value)
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

    def _kind_of(self, node: ast.Name, value: ast.expr | None) -> str:
        """Return the type that a variable has by its first value."""
        if value is None:
            raise self._wrong(node, "it has no value yet")
        found = self._expression(value)
        if not (found.is_array or found.kind in NUMBERS):
            raise self._wrong(node, "a variable is a number or an array")
        return f"{found.item}*" if found.is_array else found.kind


def declared(kind: str, kernel: Sources, *names: str) -> str:
    """Return the declaration of fields or variables of one type in C."""
    if array := re.fullmatch(r"(\w+)(\[\d+\])", kind):
        return f"{NUMBERS[array[1]]} {', '.join(name + array[2] for name in names)}"
    if kind in NUMBERS:
        return f"{NUMBERS[kind]} {', '.join(names)}"
    to = NUMBERS[kind[:-1]] if kind.endswith("*") else kernel.in_c(kind)
    return f"{to} *{', *'.join(names)}"


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


def _whole_number(node: ast.expr) -> int:
    """Return a number as written, with its sign; 0 if it is none."""
    try:
        value = ast.literal_eval(node)
    except ValueError:
        return 0
    return value if isinstance(value, int) else 0
