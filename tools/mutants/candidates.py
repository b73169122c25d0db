"""Places of the source a mutation run may change, and each change that cosmic-ray knows there.

Left out is what cannot fail or cannot run: annotations, decorators and blocks for the type checker;
``strict`` of a ``zip``, which asserts and changes nothing;
operators between kinds that never meet (bits of floats), and ``is`` for ``==``.
"""

import ast
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from itertools import islice
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.plugins import get_operator, operator_names

Position = tuple[int, int]

_LEFT_OUT = re.compile(
    r"RemoveDecorator|Variable|_(Eq|NotEq|Lt|LtE|Gt|GtE)_Is|_(Is|IsNot)_(Eq|NotEq|Lt|Gt)|"
    r"UnaryOperator_(USub|UAdd|Invert|Not)_(Not|Invert)|"
    r"Operator_(Add|Sub|Mul|Div|FloorDiv|Mod|Pow)_(BitAnd|BitOr|BitXor|LShift|RShift)|"
    r"Operator_(BitAnd|BitOr|BitXor|LShift|RShift)_(Add|Sub|Mul|Div|FloorDiv|Mod|Pow)"
)


@dataclass(frozen=True, slots=True)
class Mutant:
    """One change: the file, relative to the tree, the lines it touches, and the file's new text."""

    path: str
    first_line: int
    last_line: int
    before: str
    after: str
    text: str

    def __str__(self) -> str:
        return f"{self.path}:{self.first_line}\n    - {self.before}\n    + {self.after}"


def chosen_mutants(root: Path, folders: tuple[str, ...], count: int, seed: int) -> list[Mutant]:
    """``count`` places drawn from all the folders' modules, and one of the changes at each.

    Every place is as likely as any other, however many changes there are to choose from. Its lot
    depends on the line alone: what is written elsewhere does not draw other places.
    """
    lots: list[tuple[bytes, Path, Position]] = []
    for folder in folders:
        for path in sorted((root / folder).rglob("*.py")):
            lines = path.read_text(encoding="utf-8").splitlines()
            seen: Counter[str] = Counter()
            for line, column in sorted(_places(path)):
                name = f"{path.name} {column} {lines[line - 1]}"
                seen[name] += 1
                lots.append((_lot(seed, name, seen[name]), path, (line, column)))
    drawn = (
        _mutant(path, path.relative_to(root).as_posix(), at, lot) for lot, path, at in sorted(lots)
    )
    return list(islice(filter(None, drawn), count))


def _lot(*of: object) -> bytes:
    return sha256(repr(of).encode()).digest()


@cache
def _operators() -> dict[str, Operator]:
    names = sorted(name for name in operator_names() if not _LEFT_OUT.search(name))
    return {name: get_operator(name)() for name in names}


@cache
def _places(path: Path) -> dict[Position, tuple[tuple[str, int], ...]]:
    """Start of every place that can be changed -> (operator, number of its occurrence)."""
    source = path.read_text(encoding="utf-8")
    closed = list(_closed(ast.parse(source)))
    found: dict[Position, list[tuple[str, int]]] = {}
    lines = source.splitlines()
    nodes = list(ast_nodes(get_ast(source)))
    for name, operator in _operators().items():
        occurrence = 0
        for node in nodes:
            for start, _ in operator.mutation_positions(node):
                if not any(first <= start < last for first, last in closed) and not (
                    "BinaryOperator" in name and _unpacks(lines, start)
                ):
                    found.setdefault(start, []).append((name, occurrence))
                occurrence += 1
    return {start: tuple(changes) for start, changes in found.items()}


def _closed(tree: ast.Module) -> Iterator[tuple[Position, Position]]:
    """Stretches in which nothing is changed."""
    for node in ast.walk(tree):
        shut: list[ast.AST | None] = []
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            shut += [node.returns, *node.decorator_list]
        elif isinstance(node, ast.ClassDef):
            # What a class is made with is a declaration, as its decorators are.
            shut += [*node.decorator_list, *(keyword.value for keyword in node.keywords)]
        elif isinstance(node, ast.arg | ast.AnnAssign):
            shut += [node.annotation]
        elif isinstance(node, ast.keyword) and node.arg == "strict":
            shut += [node.value]
        elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            shut += [node]
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr):
            # A union of types: isinstance, or the name of one.
            sides = (node.left, node.right)
            if any(ast.unparse(side) == "None" or _is_type(side) for side in sides):
                shut += [node]
        for one in shut:
            if isinstance(one, ast.expr | ast.stmt):
                end = (one.end_lineno or one.lineno, one.end_col_offset or 0)
                yield (one.lineno, one.col_offset), end


def _unpacks(lines: list[str], position: Position) -> bool:
    """Whether a star is no operator: nothing stands before it that it could multiply."""
    before = (
        "".join(lines[position[0] - 2 : position[0] - 1]) + lines[position[0] - 1][: position[1]]
    )
    return before.rstrip()[-1:] in tuple("([{,=:")


def _is_type(node: ast.expr) -> bool:
    return bool(re.fullmatch(r"[A-Z][A-Za-z]*[a-z][A-Za-z]*|int|str|float|bool", ast.unparse(node)))


def _mutant(file: Path, path: str, position: Position, lot: bytes) -> Mutant | None:
    source = file.read_text(encoding="utf-8")
    changes = _places(file)[position]
    first_of = dict(reversed(changes))
    for name, occurrence in sorted(
        changes, key=lambda change: _lot(lot, change[0], change[1] - first_of[change[0]])
    ):
        try:
            text = mutate_code(source, _operators()[name], occurrence)
        except AttributeError:
            # The library exchanges the name of an exception, and falls over one with a dot in it.
            continue
        if text is not None and text != source and _compiles(text):
            break
    else:
        return None
    old, new = source.splitlines(), text.splitlines()
    first = next(i for i, (a, b) in enumerate(zip(old, new, strict=False)) if a != b)
    behind = next(
        (i for i, (a, b) in enumerate(zip(old[::-1], new[::-1], strict=False)) if a != b), 0
    )
    last = max(first, len(old) - 1 - behind)
    return Mutant(path, first + 1, last + 1, old[first].strip(), new[first].strip(), text)


def _compiles(text: str) -> bool:
    try:
        compile(text, "mutant", "exec")
    except SyntaxError:
        return False
    return True
