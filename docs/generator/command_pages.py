"""A page of the reference for each command."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import Any

import click

from docs.generator.json_tables import format_json_section, has_json
from robotcore.cli.main import robotcore


def list_command_pages() -> Iterator[tuple[str, str]]:
    """Yield the name of each page, and its Markdown."""
    context = click.Context(robotcore, info_name="robotcore")
    rows = ["| command | does |", "| --- | --- |"]
    for name, command in _list_commands(robotcore, context):
        rows.append(f"| [`{name}`]({name}.md) | {_escape(command.get_short_help_str(limit=200))} |")
        yield f"{name}.md", "\n\n".join(_format_command(command, context, 1)) + "\n"
    intro = "[The command line](../../cli.md) has examples, and the exit statuses."
    yield "index.md", "\n\n".join(["# Commands", intro, "\n".join(rows)]) + "\n"


def _list_commands(group: click.Group, context: click.Context) -> Iterator[tuple[str, click.Command]]:
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        yield name, command


def _format_command(command: click.Command, parent: click.Context, level: int) -> Iterator[str]:
    """Yield the paragraphs about a command, and about the commands of a group below it."""
    context = click.Context(command, info_name=command.name, parent=parent)
    yield f"{'#' * level} {context.command_path}"
    yield f"```text\n{command.get_usage(context).removeprefix('Usage: ')}\n```"
    yield _escape(inspect.cleandoc(command.help or "").replace("\b\n", "").replace("\f", ""))
    rows = list(_list_rows(command, context))
    if rows:
        yield "\n".join(["| option | meaning | default |", "| --- | --- | --- |", *rows])
    if has_json(command):
        yield f"{'#' * (level + 1)} JSON {{ #{context.command_path.replace(' ', '-')}-json }}"
        yield from format_json_section(context.command_path.partition(" ")[2], command)
    if isinstance(command, click.Group):
        for _, each in _list_commands(command, context):
            yield from _format_command(each, context, level + 1)


def _list_rows(command: click.Command, context: click.Context) -> Iterator[str]:
    for parameter in command.get_params(context):
        if isinstance(parameter, click.Option) and (record := parameter.get_help_record(context)):
            names, _ = record
            yield f"| `{names}` | {_escape(parameter.help or '')} | {_format_default(parameter)} |"


def _format_default(option: click.Option) -> str:
    default: Any = option.to_info_dict()["default"]
    if option.is_flag or default is None or default == () or callable(default):
        return ""
    return f"`{default}`"


def _escape(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;")
