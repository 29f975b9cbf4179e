"""Check the command lines of a page without running them: programs, options, names and files."""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from importlib.util import find_spec
from itertools import groupby, product
from pathlib import Path
from typing import Any, cast

import click

from robotcore.cli.main import robotcore
from robotcore.description import load_any, load_robot, load_world
from robotcore.errors import RobotcoreError
from robotcore.hal.backend import load_backend
from robotcore.runtime.apps import load_app
from robotcore.runtime.plan import Plan
from robotcore.runtime.request import RunRequest
from tests.docs.listings import ROOT

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

SHELL_WORDS = {"for", "do", "done"}
OPERATORS = {"&&", "||", ";", "&", "|"}
REDIRECTIONS = {">", ">>", "<"}
COMMENT = re.compile(r"(^|\s)#.*$")
ASSIGNMENT = re.compile(r"[A-Z_]+=")
EXTRAS = re.compile(r"\[([a-z,]+)\]$")
TARGETS = set(re.findall(r"^([a-z0-9-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))

NOT_CHECKED = {
    ".": "a command of the shell",
    "cd": "a command of the shell",
    "echo": "a command of the shell",
    "git": "a program of another project",
    "mkdir": "a command of the system",
    "sed": "a command of the system",
    "ssh": "needs a real robot",
    "ssh-copy-id": "needs a real robot",
    "sudo": "changes the system of a real robot",
    "dask": "a program of another project",
    "docker": "tests/system/container builds the container with another program",
    "jupyter": "a program of another project",
}
"""The programs whose arguments no test checks, and why."""

INPUTS = ("file", "files", "first", "second", "folder")
"""The parameters of commands that name files or folders which must exist."""

LOADERS: dict[str, Callable[[str], object]] = {
    "app": load_app,
    "watch": load_app,
    "judge": load_app,
    "robot": load_robot,
    "world": load_world,
    "backend": load_backend,
}
"""The functions that load what a parameter of a command names."""


def split_commands(shell: str) -> Iterator[list[str]]:
    """Yield the words of each command in the text of a shell, without redirections and comments."""
    for line in shell.replace("\\\n", " ").splitlines():
        lexer = shlex.shlex(COMMENT.sub("", line), posix=True, punctuation_chars=True)
        lexer.whitespace_split, lexer.commenters = True, ""
        for is_operator, group in groupby(lexer, OPERATORS.__contains__):
            words = list(group)
            while words and (words[0] in SHELL_WORDS - {"for"} or ASSIGNMENT.match(words[0])):
                words.pop(0)
            if words and not is_operator and words[0] != "for":
                yield list(_drop_redirections(words))


def _drop_redirections(words: Sequence[str]) -> Iterator[str]:
    following = iter(words)
    for word in following:
        if word in REDIRECTIONS:
            next(following)
        else:
            yield word


def find_mistake(words: Sequence[str]) -> str:
    """Return the problem of a command in the current folder; ``""`` if it has none."""
    program, *arguments = words
    if program == "robotcore":
        return _find_mistake_of_robotcore(arguments)
    if program == "make":
        return ", ".join(f"no target {each}" for each in arguments if each not in TARGETS)
    if program == "sh":
        return "" if Path(arguments[0]).is_file() else f"{arguments[0]} does not exist"
    if program in ("python", "python3", "pytest", "pip"):
        return _find_mistake_of_python(program, arguments)
    return "" if program in NOT_CHECKED else f"unknown program {program}"


def parse(arguments: Sequence[str]) -> tuple[str, Mapping[str, Any]]:
    """Return the name of a command of robotcore and its parameters. Raises click's and robotcore's errors."""
    name, command, words = "", cast("click.Command", robotcore), list(arguments)
    context = click.Context(command)
    while isinstance(command, click.Group):
        found, following, words = command.resolve_command(context, words)
        assert found
        assert following
        name, command = f"{name} {found}".strip(), following
    return name, command.make_context(name, words).params


def _find_mistake_of_robotcore(arguments: Sequence[str]) -> str:
    try:
        _require_names(*parse(arguments))
    except (click.ClickException, RobotcoreError, OSError) as error:
        return getattr(error, "message", "") or str(error)
    return ""


def _require_names(name: str, parameters: Mapping[str, Any]) -> None:
    """Raise an error if a parameter names an app, a robot, a world, a backend or a file that does not exist."""
    if name == "run":
        Plan.resolve(_build_request(parameters))
    elif name == "sweep":
        for backend, world in product(parameters["backends"], parameters["worlds"]):
            Plan.resolve(_build_request({**parameters, "backend": backend, "world": world}))
    else:
        for key, load in LOADERS.items():
            if parameters.get(key):
                load(parameters[key])
    if name not in ("new", "firmware copy"):
        for key in INPUTS:
            _require_input(parameters.get(key))


def _require_input(given: str | Path | tuple[Path, ...] | None) -> None:
    if isinstance(given, str):
        load_any(given)
        return
    for path in given if isinstance(given, tuple) else filter(None, [given]):
        if not path.exists():
            raise FileNotFoundError(f"{path} does not exist")


def _build_request(parameters: Mapping[str, Any]) -> RunRequest:
    known = {field.name for field in fields(RunRequest)}
    values = {key: value for key, value in parameters.items() if key in known}
    connection = {key: value for key in ("host", "port") if (value := parameters.get(key))}
    options = {**dict(parameters["options"]), **connection}
    return RunRequest(**{**values, "settings": dict(parameters["settings"]), "options": options})


def _find_mistake_of_python(program: str, arguments: Sequence[str]) -> str:
    match arguments:
        case ["-m", "pip", *rest]:
            return _find_mistake_of_pip(rest)
        case ["-m", "pytest" | "venv" | "mujoco.viewer", *_]:
            return ""
        case ["-m", module, *options]:
            return _find_mistake_of_module(module, options)
        case ["install", *_] if program == "pip":
            return _find_mistake_of_pip(arguments)
    files = [each for each in arguments if each.endswith(".py")]
    return ", ".join(f"{file} does not exist" for file in files if not Path(file).is_file())


def _find_mistake_of_pip(arguments: Sequence[str]) -> str:
    known = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    extras = [extra for each in arguments for found in EXTRAS.findall(each) for extra in found.split(",")]
    return ", ".join(f"no extra {extra}" for extra in extras if extra not in known)


def _find_mistake_of_module(module: str, options: Sequence[str]) -> str:
    spec = find_spec(module)
    if spec is None or not spec.origin:
        return f"no module {module}"
    source = Path(spec.origin).read_text(encoding="utf-8")
    named = [each for each in options if each.startswith("--")]
    return ", ".join(f"no option {each}" for each in named if not re.search(rf'"{each}"|\b{each[2:]}=', source))
