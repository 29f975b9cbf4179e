"""The files that a reader of the pages has: those of the pages' listings, and those that the commands write."""

from __future__ import annotations

from pathlib import Path

from robotcore.cli.scaffold import PROJECT, make
from tests.docs.listings import Listing, list_listings, read_pages
from tests.robotcore.description.files import ARENA, ROVER, SHIPPED

APPS = {
    "reflex.py": "README.md",
    "explore.py": "docs/manoeuvres.md",
    "patrol.py": "README.md",
    "handed_in/kim/robot.py": "README.md",
    "my_app.py": "README.md",
}
"""The files of apps that pages name, and the page whose first app is in the file."""

BUBBLEROB = SHIPPED.joinpath("robots", "bubblerob.toml").read_text(encoding="utf-8")
GAMEPAD = '\n[[devices]]\nkind = "gamepad"\nname = "pad"\n'
STRICT = "from apps.green_search import GreenSearch\n\n\nclass Strict(GreenSearch):\n    pass\n"

TEXTS = {
    "my_robot.toml": ROVER,
    "true_robot.toml": ROVER,
    "driven.toml": ROVER + GAMEPAD,
    "my_arena.toml": ARENA,
    "my_room.toml": ARENA,
    "strict.py": STRICT,
    "lab.ssh": "Host rover-3\n",
}
RECORDINGS = ("run", "real", "reflex", "bullet", "before", "after", "first")
FOLDERS = ("robotcore_bridge", "board")


def write_reader_files(page: str, folder: Path) -> None:
    """Write the files that a reader of a page has into a folder.

    page: the name of the page, such as ``docs/apps.md``.
    """
    make(PROJECT, folder / "my-robot")
    for file in ("search.py", "room.toml", "ci.sh"):
        (folder / file).write_bytes((folder / "my-robot" / file).read_bytes())
    pages = read_pages()
    tutorial = list_listings(pages["docs/tutorials/bubblerob.md"])
    wiring = next(each.text for each in tutorial if "[raspberrypi." in each.text)
    texts = {**TEXTS, "my_bubblerob.toml": f"{BUBBLEROB}\n{wiring}"}
    for file, source in APPS.items():
        texts[file] = next(each.text for each in list_listings(pages[source]) if "Behaviour" in each.text)
    texts |= {each.file: each.text for each in list_listings(pages[page]) if is_python_file(each)}
    for file, text in texts.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(text, encoding="utf-8")
    for name in RECORDINGS:
        (folder / f"{name}.mcap").touch()
    for name in FOLDERS:
        (folder / name).mkdir()


def is_python_file(listing: Listing) -> bool:
    """Return whether a listing is a file, whose name is in its first line."""
    return listing.language == "python" and listing.file.endswith(".py") and " " not in listing.file
