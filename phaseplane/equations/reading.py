"""Reading a formula: a text becomes a tree of checked nodes, or a message that says what to write."""

from __future__ import annotations

import ast
import re

from phaseplane.suspension.units import counted, nearest

SMOOTH = (
    "acos", "asin", "atan", "cos", "cosh", "exp", "hypot", "log", "sin", "sinh", "sqrt", "tan", "tanh",
)  # fmt: skip
PIECES = {  # least and most arguments
    "abs": (1, 1), "atan2": (2, 2), "backlash": (2, 2), "copysign": (2, 2), "dead_zone": (2, 2),
    "max": (2, 99), "min": (2, 99), "relay": (1, 2), "saturation": (2, 2), "sign": (1, 1),
}  # fmt: skip
FUNCTIONS = tuple(sorted((*SMOOTH, *PIECES)))
"""The functions of a formula."""

_BINARY = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow)
_UNARY = (ast.USub, ast.UAdd)
_LONGEST = 1000
_TOKEN = re.compile(r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[^\W\d]\w*|\S")


def read(text: str, names: tuple[str, ...], section: str) -> ast.expr:
    """Parse a formula into a tree of checked nodes only: no attributes, no other calls."""
    if len(text) > _LONGEST:
        raise ValueError(f"equation: {len(text)} characters; at most {_LONGEST} are allowed")
    try:
        if "#" in text:  # Python would read a comment
            raise ValueError
        tree = ast.parse(text.strip().replace("^", "**"), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(f"equation = {text!r}: not a formula; {_hint(text)}") from None
    body = _checked(tree.body, text, names, section)
    return ast.fix_missing_locations(ast.Expression(body)).body


_HABITS = (  # other notations, and what to write
    (r"#", "write comments after the closing quotation mark"),
    (
        r"[<>]|\b(if|else|and|or|not)\b",
        "write cases by sign, abs, max, min, dead_zone or saturation",
    ),
    (r"['\u2019=\u0307\u0308ẋẍ]", "write f of x'' + f = 0 alone, with v for x'"),
    (r"\d,\d", "write numbers with a point, such as 1.5"),
    (r"[²³]", "write powers with ^, such as x^2"),
    (r"\|", "write abs(x) for |x|"),
    (rf"\b({'|'.join(FUNCTIONS)})\s+\w", "write arguments in brackets, such as sin(x)"),
    (r"\blambda\b", "lambda is reserved: write λ"),
)
_SYNONYMS = {
    "ln": "log", "sgn": "sign", "signum": "sign", "arctan": "atan", "arcsin": "asin",
    "arccos": "acos", "heaviside": "0.5*(1 + sign(...))", "step": "0.5*(1 + sign(...))",
    "e": "exp(1)", "ẋ": "v", "cot": "1/tan(...)", "cbrt": "sign(x)*abs(x)^(1/3)",
}  # fmt: skip


def _hint(text: str) -> str:
    """Return what to try in place of a text that is no formula."""
    products = _with_products(text)
    if products:
        return f"did you mean {products!r}?"
    habits = (words for pattern, words in _HABITS if re.search(pattern, text))
    return next(habits, "write one such as '(x^2 - 1)*v + x'")


def _with_products(text: str) -> str:
    """Return a formula with omitted * inserted, as in 2v; empty if the result is not a formula."""
    found, last, end = "", "", 0
    for token in _TOKEN.finditer(text.strip()):
        ends = last and (last[-1].isalnum() or last == ")") and last not in FUNCTIONS
        begins = token[0][0].isalnum() or token[0] == "("
        gap = text.strip()[end : token.start()]
        found += ("*" if ends and begins else gap) + token[0]
        last, end = token[0], token.end()
    try:
        ast.parse(found.replace("^", "**"), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ""
    return "" if found == text.strip() else found


def _checked(node: ast.expr, text: str, names: tuple[str, ...], section: str) -> ast.expr:
    """Return the checked node, with integers as floats, so that powers cannot grow without limit."""

    def checked(part: ast.expr) -> ast.expr:
        return _checked(part, text, names, section)

    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            try:
                return ast.Constant(float(value))
            except OverflowError:
                raise ValueError(
                    f"equation: {text!r} contains a number that is too large"
                ) from None
        case ast.BinOp(left, operator, right) if isinstance(operator, _BINARY):
            return ast.BinOp(checked(left), operator, checked(right))
        case ast.UnaryOp(operator, operand) if isinstance(operator, _UNARY):
            return ast.UnaryOp(operator, checked(operand))
        case ast.Name(name) if name in names:
            return node
        case ast.Call(ast.Name(name) as called, arguments, []) if name in FUNCTIONS:
            _check_count(name, len(arguments), text)
            return ast.Call(called, [checked(a) for a in arguments], [])
    own = node.func if isinstance(node, ast.Call) else None
    if isinstance(own, ast.Constant | ast.BinOp) or (own and ast.unparse(own) in names):
        hint = _with_products(text)
        if hint:
            raise ValueError(f"equation = {text!r}: not a formula; did you mean {hint!r}?")
    part = ast.unparse(node)
    name = part.split("(")[0]
    hint = nearest(name, (*names, *FUNCTIONS)) if len(name) > 1 else ""
    if name.lower() in _SYNONYMS:
        hint = f"; did you mean {_SYNONYMS[name.lower()]!r}?"
    elif not isinstance(node, ast.Name | ast.Call):
        hint = f"; {_hint(text)}"
    allowed = f"allowed are numbers, + - * / ^, {', '.join(names)} and {', '.join(FUNCTIONS)}"
    if isinstance(node, ast.Name) and part not in FUNCTIONS:
        give = f"give its value in [{section}], such as {part} = 1.0"
        hint = f"{hint} Otherwise {give}" if hint else f"; {give}"
    raise ValueError(f"equation = {text!r}: {part!r} is not known{hint}; {allowed}")


def _check_count(name: str, count: int, text: str) -> None:
    least, most = PIECES.get(name, (2, 2) if name == "hypot" else (1, 1))
    if not least <= count <= most:
        wanted = counted(least, "value") if least == most else f"{least} or {most} values"
        wanted = "at least 2 values" if most > 2 else wanted
        raise ValueError(f"equation = {text!r}: {name} takes {wanted}, not {count}")
