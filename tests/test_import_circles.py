"""No module of the program imports itself by way of others.

Every import counts: at the top, inside a function, and for types only. Who knows whom is a matter
of the design, not of the moment the import runs.
"""

import ast
from pathlib import Path

SRC = Path(__file__).parent.parent / "src"


def imported(path: Path, modules: set[str]) -> set[str]:
    """Modules of the program that a file imports, wherever the import stands."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            inner = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= (inner & modules) or {node.module}
    return found & modules


def import_graph(root: Path) -> dict[str, set[str]]:
    """Each module and what it imports."""
    paths = {}
    for path in root.rglob("*.py"):
        parts = path.relative_to(root).with_suffix("").parts
        paths[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return {name: imported(path, set(paths)) - {name} for name, path in paths.items()}


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """The groups of modules that reach one another, largest first (Tarjan's components)."""
    order: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(name: str) -> None:
        order[name] = low[name] = len(order)
        stack.append(name)
        for other in sorted(graph[name]):
            if other not in order:
                visit(other)
                low[name] = min(low[name], low[other])
            elif other in stack:
                low[name] = min(low[name], order[other])
        if low[name] == order[name]:
            at = stack.index(name)
            group = stack[at:]
            del stack[at:]
            if len(group) > 1:
                found.append(sorted(group))

    for name in sorted(graph):
        if name not in order:
            visit(name)
    return sorted(found, key=lambda group: (-len(group), group))


def test_a_circle_is_found_wherever_its_imports_stand(tmp_path: Path) -> None:
    package = tmp_path / "one"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "a.py").write_text("from one import b\n")
    (package / "b.py").write_text("def late():\n    from one.c import x\n    return x\n")
    (package / "c.py").write_text("if TYPE_CHECKING:\n    import one.a\nx = 1\n")
    assert circles(import_graph(tmp_path)) == [["one.a", "one.b", "one.c"]]


def test_no_circle_anywhere_in_the_program() -> None:
    assert circles(import_graph(SRC)) == []
