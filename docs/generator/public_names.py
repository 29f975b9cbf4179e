"""The public names of robotcore, which the reference shows and the tests check."""

from __future__ import annotations

import ast
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from docs.generator.public_modules import PUBLIC_MODULES

MODULES = [module for modules in PUBLIC_MODULES.values() for module in modules]


def list_public_names(module: str) -> list[str]:
    """Return the names in a module's ``__all__``; without it, those that the module defines without an underscore."""
    listed: list[str] | None = getattr(import_module(module), "__all__", None)
    if listed is not None:
        return listed
    names = list(find_assignments(module))
    names += [node.name for node in parse_module(module).body if isinstance(node, (ast.ClassDef, ast.FunctionDef))]
    return [name for name in names if not name.startswith("_")]


def is_defined_in_robotcore(value: Any) -> bool:
    """Return whether robotcore defines a class or a function."""
    return str(getattr(value, "__module__", "")).partition(".")[0] == "robotcore"


@cache
def parse_module(module: str) -> ast.Module:
    """Return the syntax tree of a module."""
    path = import_module(module).__file__
    assert path
    return ast.parse(Path(path).read_text(encoding="utf-8"))


@cache
def find_assignments(module: str) -> dict[str, bool]:
    """Return whether a string follows the assignment of each name."""
    body = parse_module(module).body
    found: dict[str, bool] = {}
    for node, following in zip(body, [*body[1:], ast.Pass()], strict=True):
        is_documented = isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant)
        for target in _list_targets(node):
            found |= {each.id: is_documented for each in ast.walk(target) if isinstance(each, ast.Name)}
    return found


def _list_targets(node: ast.stmt) -> list[ast.expr]:
    if isinstance(node, ast.AnnAssign):
        return [node.target]
    return node.targets if isinstance(node, ast.Assign) else []
