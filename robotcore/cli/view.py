"""``robotcore view`` shows recordings on the live page."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from pathlib import Path

import click

from robotcore.cli.output import write_line, write_lines
from robotcore.errors import UsageError
from robotcore.extras import require_extra

MAX_FILES = 2


@click.command("view")
@click.argument("files", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option(
    "--listen", "address", metavar="HOST:PORT", help="Where the page listens. Default: a free port on 127.0.0.1."
)
def command(files: tuple[Path, ...], address: str | None) -> None:
    """Show a recording on a web page, or two side by side.

    The page has a time slider, and plays the run or shows tick after tick. Ctrl-C ends it.
    """
    from robotcore.live.address import Address, build_token
    from robotcore.live.live_view import describe_link

    if len(files) > MAX_FILES:
        raise UsageError("robotcore view shows at most two recordings", kind="too-many-files", count=len(files))
    require_extra("view", "the page")
    from robotcore.live.playback import Playback
    from robotcore.live.playback_server import serve
    from robotcore.live.server import use_selectors

    has_same_names = len({file.name for file in files}) < len(files)
    playbacks = [Playback(file, str(file) if has_same_names else file.name) for file in files]
    place = Address.parse(address) if address else Address()
    with place.listen() as listener:
        token = build_token(place)
        for playback in playbacks:
            for problem in playback.problems:
                write_line(f"{playback.name}: {problem}", is_error=True)
        write_lines(describe_link(place.build_link(listener.getsockname()[1], token), is_public=bool(token)))
        with suppress(KeyboardInterrupt):
            use_selectors()
            asyncio.run(serve(listener, playbacks, token, place.list_hosts()))
