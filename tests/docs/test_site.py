"""The documentation site builds without a warning, and has a page for each public name. Its search needs no server."""

from __future__ import annotations

import re
import subprocess
import sys
from ast import literal_eval
from collections import Counter
from importlib import import_module
from inspect import isclass, isroutine
from pathlib import Path

import pytest
from click import Context

from docs.generator.api_pages import list_api_pages, name_page
from docs.generator.error_catalogue import Entry
from docs.generator.error_pages import build_catalogue, explain, read_notes
from docs.generator.public_modules import PUBLIC_MODULES
from docs.generator.public_names import list_public_names
from robotcore.cli.main import robotcore
from robotcore.description import RobotDescription, WorldDescription
from robotcore.plugins import app_names, backend_names, device_driver_names, fault_names, kind_names
from tests.robotcore.live.chromium import require_chromium

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def catalogue() -> dict[str, Entry]:
    """Read each error of the source. This takes seconds, so only the tests that need it do it."""
    return build_catalogue()


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("documentation") / "site"
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    return folder


def read_page(site: Path, page: str) -> str:
    return (site / "reference" / page).with_suffix(".html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_page_of_each_public_module_has_its_names(site: Path) -> None:
    missing = []
    for title, modules in PUBLIC_MODULES.items():
        page = read_page(site, f"api/{name_page(title)}")
        names = (f"{module}.{name}" for module in modules for name in list_public_names(module))
        missing += [name for name in names if name.rpartition(".")[2] not in page]
    assert missing == []


def test_reference_shows_each_class_and_function_once() -> None:
    directive = re.compile(r"::: (\S+)\n +options:\n +members: (.+)")
    shown = [
        f"{value.__module__}.{value.__qualname__}"
        for _, page in list_api_pages()
        for module, members in directive.findall(page)
        for value in (getattr(import_module(module), name) for name in literal_eval(members))
        if isclass(value) or isroutine(value)
    ]
    assert len(shown) > 200
    assert [name for name, times in Counter(shown).items() if times > 1] == []


def test_messages_of_errors_name_nothing_of_the_tests(catalogue: dict[str, Entry]) -> None:
    examples = {kind: entry.examples for kind, entry in catalogue.items()}
    assert [kind for kind, texts in examples.items() if "TMP" in str(texts) or "<locals>" in str(texts)] == []
    assert [kind for kind in catalogue if not re.fullmatch(r"[a-z0-9-]+", kind)] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "page, names",
    [
        ("backends.md", backend_names()),
        ("device-kinds.md", kind_names()),
        ("device-drivers.md", device_driver_names()),
        ("faults.md", fault_names()),
        ("apps.md", app_names()),
        ("robot-file.md", list(RobotDescription.model_fields)),
        ("world-file.md", list(WorldDescription.model_fields)),
    ],
)
def test_page_of_the_reference_has_each_installed_part(site: Path, page: str, names: list[str]) -> None:
    text = read_page(site, page)
    assert [name for name in names if name not in text] == []


@pytest.mark.slow
def test_each_command_and_each_error_has_a_page(site: Path, catalogue: dict[str, Entry]) -> None:
    commands = robotcore.list_commands(Context(robotcore))
    pages = [f"commands/{name}" for name in commands] + [f"errors/{kind}" for kind in catalogue]
    assert [page for page in pages if not (site / "reference" / f"{page}.html").is_file()] == []


def test_each_error_has_a_cause_and_a_remedy(catalogue: dict[str, Entry]) -> None:
    explained = {kind: explain(entry) for kind, entry in catalogue.items()}
    assert [kind for kind, pairs in explained.items() if not pairs or not all(map(all, pairs))] == []


def test_notes_about_errors_are_about_errors_of_the_source(catalogue: dict[str, Entry]) -> None:
    assert read_notes().keys() - catalogue.keys() == {"classes"}


@pytest.mark.slow
def test_search_of_the_opened_files_finds_an_error_without_a_server(site: Path) -> None:
    program = require_chromium()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as started:
        chromium = started.chromium.launch(executable_path=program, args=["--no-sandbox"])
        page = chromium.new_page()
        requests: list[str] = []
        page.on("request", lambda request: requests.append(request.url))
        page.goto((site / "index.html").as_uri())
        page.locator("[data-md-component=search-query]").fill("motors-not-stopped")
        page.locator(".md-search-result__item", has_text="motors-not-stopped").first.wait_for()
        chromium.close()
    assert [url for url in requests if not url.startswith(("file:", "data:"))] == []
