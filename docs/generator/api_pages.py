"""A page of the reference for each group of public modules, with the directives of mkdocstrings."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from inspect import isclass, isroutine

from docs.generator.key_tables import read_docstrings, read_summary
from docs.generator.public_modules import PUBLIC_MODULES
from docs.generator.public_names import MODULES, list_public_names

ROOT_PACKAGE = "robotcore"


def list_api_pages() -> Iterator[tuple[str, str]]:
    """Yield the name of each page, and its Markdown."""
    for title, modules in PUBLIC_MODULES.items():
        yield name_page(title), "\n\n".join([f"# {title}", *map(_format_module, modules)]) + "\n"


def name_page(title: str) -> str:
    """Return the file of a page, such as ``manoeuvres-and-routines.md``."""
    return f"{title.lower().replace(' ', '-')}.md"


def _format_module(name: str) -> str:
    if name == ROOT_PACKAGE:
        return _format_root_package()
    members = [each for each in list_public_names(name) if _is_shown_by(name, each)]
    return f"::: {name}\n    options:\n      members: {members}"


def _is_shown_by(module: str, name: str) -> bool:
    """Return whether the page shows a name below this module. A class is shown below the module that defines it."""
    value = getattr(import_module(module), name)
    is_imported = (isclass(value) or isroutine(value)) and value.__module__ != module
    return not is_imported or value.__module__ not in MODULES


def _format_root_package() -> str:
    """Return a table of the names of `import robotcore`. Their own modules have the full text."""
    package = import_module(ROOT_PACKAGE)
    rows = ["| name | meaning |", "| --- | --- |"]
    modules = map(import_module, PUBLIC_MODULES["Apps"] + PUBLIC_MODULES["Vision"])
    constants = {name: text for module in modules for name, text in read_docstrings(module).items()}
    for name in sorted(package.__all__):
        value = getattr(package, name)
        is_object = getattr(value, "__module__", "").startswith(ROOT_PACKAGE)
        link = f"[`{name}`][{value.__module__}.{value.__qualname__}]" if is_object else f"`{name}`"
        rows.append(f"| {link} | {read_summary(value) if is_object else constants.get(name) or read_summary(value)} |")
    return "## robotcore\n\nAn app, a notebook and a test of an app need only `import robotcore`.\n\n" + "\n".join(rows)
