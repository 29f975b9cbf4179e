"""``robotcore apps``: what can be run, what each needs, and what can be set on it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.output import as_json, write_json, write_table

if TYPE_CHECKING:
    from robotcore.runtime.settings import Setting


@click.command("apps")
@as_json
def command(*, as_json: bool) -> None:
    """List the apps, their needs and settings."""
    from robotcore.plugins import app_names

    apps = [_app_row(name) for name in app_names()]
    if as_json:
        write_json(apps)
    else:
        write_table(("app", "needs", "settings", "what it does"), map(_row, apps))


def _app_row(name: str) -> dict[str, Any]:
    from robotcore.errors import BackendMissingError
    from robotcore.runtime.apps import load_app
    from robotcore.runtime.settings import settings_of

    try:
        app = load_app(name)
    except BackendMissingError as error:
        return {"name": name, "summary": str(error), "needs": [], "milestones": [], "settings": []}
    return {
        "name": name,
        "summary": (app.__doc__ or "").strip().partition("\n")[0],
        "needs": sorted(role.value for role in app.needs),
        "milestones": list(app.milestones),
        "settings": [_setting(setting) for setting in settings_of(app).values()],
    }


def _setting(setting: Setting) -> dict[str, Any]:
    has_plain_default = setting.default is None or isinstance(setting.default, (bool, int, float, str))
    return {
        "name": setting.name,
        "type": _type_name(setting.type),
        "default": setting.default if has_plain_default else str(setting.default),
    }


def _type_name(kind: Any) -> str:
    """Return a type as one would write it, its limits left out."""
    bare = getattr(kind, "__origin__", kind) if hasattr(kind, "__metadata__") else kind
    return bare.__name__ if isinstance(bare, type) else str(bare)


def _row(app: dict[str, Any]) -> tuple[str, ...]:
    settings = "\n".join(f"{each['name']}={each['default']} ({each['type']})" for each in app["settings"])
    return app["name"], ", ".join(app["needs"]), settings, app["summary"]
