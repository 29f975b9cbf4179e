"""Read the identifier, the messages and the class of each error from the source, and examples from the tests."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from robotcore.errors import RobotcoreError

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ("robotcore", "drivers", "apps")
TEMPLATES = "templates"
"""The folder of the files that `robotcore new` copies. They are not the project's own code."""

REMEDY_POSITIONS = {"DescriptionError": (2, 3), "RecordingError": (1, 2), "MapError": (1, 2), "Mistake": (0, 1)}
"""The positions of the problem and the remedy in the arguments of an error's class."""

FINDINGS = {"Finding.warning": (1, 2), "Finding.error": (1, 2), "Finding.unchecked": (1, 2)}
"""The same for the findings of `robotcore doctor` that are not in order."""

PROBLEM_POSITION = {"DeviceError": 1, "DeviceLostError": 1}
"""The position of the message, if it is not the first argument."""

PREFIXES = {"DeviceError": "DEVICE: ", "DeviceLostError": "DEVICE: ", "RecordingError": "FILE: ", "MapError": "FILE: "}
"""The beginning of the messages of a class, which its constructor writes."""

KIND = re.compile(r"[a-z0-9-]+")
SENTENCE_END = re.compile(r"(?<=[.?!…])\s+(?=[A-Z`'\"…])|; (?=(?:take|pass|set|write|check|give|call|it must)\b)")


class Message(NamedTuple):
    """A message of an error: what happened, and what to do. A value in it is an upper-case word or ``…``."""

    problem: str
    remedy: str


@dataclass
class Entry:
    """An identifier, and everything that the source and the tests say about it."""

    kind: str
    owners: set[str] = field(default_factory=set)
    """The names of the classes of errors with this identifier; ``Finding`` for a finding."""
    messages: list[Message] = field(default_factory=list)
    modules: set[str] = field(default_factory=set)
    """The modules that raise it."""
    examples: list[str] = field(default_factory=list)
    """Messages from the tests."""

    @property
    def errors(self) -> list[type[RobotcoreError]]:
        """The classes of errors with this identifier that the project's tree contains, by name."""
        return sorted(
            (each for each in list_error_classes() if each.__name__ in self.owners), key=lambda each: each.__name__
        )


def read_catalogue() -> dict[str, Entry]:
    """Return the entries of all errors and findings by identifier, in alphabetical order."""
    entries: dict[str, Entry] = {}

    def add_entry(kind: str, owner: str) -> Entry:
        found = entries.setdefault(kind, Entry(kind))
        found.owners.add(owner)
        return found

    for error in list_error_classes():
        add_entry(error.kind, error.__name__)
    for file, tree in _parse_sources():
        module = ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for kind, owner, message in _find_raise_calls(tree):
            found = add_entry(kind, owner)
            found.modules.add(module)
            if message and message not in found.messages:
                found.messages.append(message)
    for kind, owner, text in _find_examples():
        if "<locals>" in text or not KIND.fullmatch(kind):
            continue  # a name of the test itself
        found = add_entry(kind, owner)
        if text not in found.examples:
            found.examples.append(text)
    return dict(sorted(entries.items()))


def list_messages(entry: Entry) -> list[Message]:
    """Return the messages of an error that name its cause: those of the source, or else those of the tests."""
    examples = [split_message(text) for text in entry.examples]
    return [each for each in entry.messages if has_words(each.problem)] or [
        each for each in examples if has_words(each.problem)
    ]


def has_words(text: str) -> bool:
    """Return whether a text says something, besides the names of its values."""
    return len(re.findall(r"\b[A-Za-z][a-z]+", text)) > 1


@cache
def list_error_classes() -> list[type[RobotcoreError]]:
    """Return all classes of errors, after an import of the modules that define some."""
    for file, tree in _parse_sources():
        if any(isinstance(node, ast.ClassDef) and node.name.endswith("Error") for node in tree.body):
            import_module(".".join(file.relative_to(ROOT).with_suffix("").parts))
    found, rest = [], [RobotcoreError]
    while rest:
        found.append(each := rest.pop())
        rest.extend(each.__subclasses__())
    return [each for each in found if each.__module__.partition(".")[0] in SOURCES]


def split_message(text: str) -> Message:
    """Return the first sentence of a message as its problem, and the others as its remedy."""
    problem, *others = SENTENCE_END.split(text)
    return Message(problem.removesuffix("."), " ".join(others).removesuffix("."))


def _parse_sources() -> Iterator[tuple[Path, ast.Module]]:
    for top in SOURCES:
        for file in sorted((ROOT / top).rglob("*.py")):
            if TEMPLATES not in file.parts:
                yield file, ast.parse(file.read_text(encoding="utf-8"))


def _find_raise_calls(tree: ast.Module) -> Iterator[tuple[str, str, Message | None]]:
    constants = _find_assignments(ast.Module([node for node in tree.body if isinstance(node, ast.Assign)], []))
    for scope in [tree, *(node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))]:
        assignments = constants + _find_assignments(scope)
        for call in _list_calls(scope):
            texts = {name: value for line, name, value in assignments if line <= call.lineno}
            owner = ast.unparse(call.func)
            if owner == "UnknownNameError" and call.args and isinstance(call.args[0], ast.Constant):
                noun = str(call.args[0].value)
                yield f"unknown-{noun.replace(' ', '-')}", owner, Message(f"unknown {noun} NAME", "Did you mean …?")
            elif owner.endswith(("Error", "SafetyStop", "Mistake")) or owner in FINDINGS:
                for keyword in call.keywords:
                    if keyword.arg == "kind" and isinstance(keyword.value, ast.Constant):
                        yield str(keyword.value.value), owner.partition(".")[0], _read_message(call, owner, texts)


def _list_calls(scope: ast.AST) -> Iterator[ast.Call]:
    """Yield the calls in a module or function, without those in functions inside it."""
    for node in ast.iter_child_nodes(scope):
        if isinstance(node, ast.Call):
            yield node
        if not isinstance(node, ast.FunctionDef):
            yield from _list_calls(node)


def _find_assignments(scope: ast.AST) -> list[tuple[int, str, ast.expr]]:
    """Return the line, the variable and the expression of each assignment, from the first line to the last."""
    found = [
        (node.lineno, target.id, node.value)
        for node in ast.walk(scope)
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    ]
    return sorted(found, key=lambda each: each[0])


def _read_message(call: ast.Call, owner: str, texts: dict[str, ast.expr]) -> Message | None:
    positions = REMEDY_POSITIONS.get(owner) or FINDINGS.get(owner)
    if positions:
        problem, remedy = (_format_argument(call, each, texts) for each in positions)
        if owner == "Mistake" and not remedy:
            remedy = "Correct it"
        problem = PREFIXES.get(owner, "") + problem
        return Message(problem, remedy) if remedy else split_message(problem)
    text = _format_argument(call, PROBLEM_POSITION.get(owner, 0), texts)
    return split_message(PREFIXES.get(owner, "") + text) if text.strip("…") else None


def _format_argument(call: ast.Call, position: int, texts: dict[str, ast.expr]) -> str:
    if position >= len(call.args) or any(isinstance(each, ast.Starred) for each in call.args):
        return ""
    return _format(call.args[position], texts)


def _format(text: ast.expr, texts: dict[str, ast.expr]) -> str:
    """Return the text of an expression, with an upper-case word or ``…`` in place of each value."""
    match text:
        case ast.Constant(value=value):
            found = str(value)
        case ast.JoinedStr(values=values):
            found = "".join(_format(value, texts) for value in values)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            found = _format(left, texts) + _format(right, texts)
        case ast.FormattedValue(value=ast.Name() | ast.Attribute() | ast.IfExp() as value) | ast.IfExp(body=value):
            found = _format(value, texts)
        case ast.Name(id=name) if isinstance(texts.get(name), ast.Constant | ast.JoinedStr | ast.BinOp | ast.IfExp):
            found = _format(texts[name], {each: text for each, text in texts.items() if each != name})
        case ast.Name(id=name) | ast.Attribute(attr=name):
            found = name.strip("_").upper()
        case _:
            found = "…"
    return found


def _find_examples() -> Iterator[tuple[str, str, str]]:
    """Yield the identifier, the class and the text of each error that a test expects by the fixture `raises`."""
    for snapshots in sorted((ROOT / "tests").glob("*/**/texts.json")):
        texts = json.loads(snapshots.read_text(encoding="utf-8"))
        for file in sorted(snapshots.parent.glob("test_*.py")):
            tree = ast.parse(file.read_text(encoding="utf-8"))
            for test in (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)):
                calls = [call for call in ast.walk(test) if isinstance(call, ast.Call) and _is_expectation(call)]
                known = [
                    text
                    for key, text in texts.items()
                    if key.split("[")[0].split(" ")[0] == f"{file.stem}::{test.name}"
                ]
                if len(calls) == 1 and known:
                    owner, kind = calls[0].args[:2]
                    yield ast.literal_eval(kind), ast.unparse(owner).rpartition(".")[2], _shorten(known[0])


def _shorten(text: str) -> str:
    """Return a message of a test without its folder, and only the first of several mistakes in a file."""
    first, *others = text.replace("TMP/", "").replace("TMP", "FOLDER").strip().splitlines()
    label = first.removeprefix("check: ").partition(": ")[0]
    is_list = any(each.startswith(label) for each in others)
    return first if is_list else "\n".join([first, *others])


def _is_expectation(call: ast.Call) -> bool:
    is_raises = isinstance(call.func, ast.Name) and call.func.id == "raises" and len(call.args) > 1
    return is_raises and isinstance(call.args[1], ast.Constant)
