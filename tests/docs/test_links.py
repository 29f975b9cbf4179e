"""Each relative link and each anchor of the pages exists, on the documentation site and in a repository's browser."""

from __future__ import annotations

import re
import unicodedata
from functools import cache
from pathlib import Path

import pytest

from docs.generator.error_pages import NOTES
from docs.generator.plugin_pages import list_plugin_pages
from tests.docs.listings import CODE, FENCE, ROOT, read_pages

PAGES = read_pages()
LINK = re.compile(r"\[(?:[^\]\[]|\[[^\]]*\])*\]\(\s*<?([^)\s>]+)>?[^)]*\)")
DEFINITION = re.compile(r"^\[[^\]]+\]:\s+(\S+)", re.MULTILINE)
HEADING = re.compile(r"^#+\s+(.*?)\s*#*$", re.MULTILINE)
TEMPLATES = "robotcore/cli/scaffold/templates/"


def list_links(text: str) -> list[str]:
    """Return the relative targets of the links and pictures in the text of a page."""
    plain = CODE.sub("`code`", FENCE.sub("", text))
    found = [*LINK.findall(plain), *DEFINITION.findall(plain)]
    return [link for link in found if not re.match(r"[a-z]+:", link)]


def slugify_for_browser(heading: str) -> str:
    """Return the anchor of a heading in the browser of a repository."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def slugify_for_site(heading: str) -> str:
    """Return the anchor of a heading on the site, as Python-Markdown does."""
    plain = unicodedata.normalize("NFKD", heading).encode("ascii", "ignore").decode()
    return re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", plain).strip().lower())


@cache
def list_anchors(page: str) -> tuple[set[str], set[str]]:
    """Return the anchors of a page in a repository's browser, and on the site."""
    texts = [re.sub(r"[`*]|\]\([^)]*\)|\[", "", each) for each in HEADING.findall(FENCE.sub("", PAGES[page]))]
    return set(map(slugify_for_browser, texts)), set(map(slugify_for_site, texts))


def find_mistake(page: str, link: str) -> str:
    """Return the problem of a relative link of a page; ``""`` if it has none."""
    path, _, anchor = link.partition("#")
    target = ((ROOT / page).parent / path).resolve() if path else ROOT / page
    if not target.exists():
        return "the file does not exist"
    if not anchor:
        return ""
    name = Path(target).relative_to(ROOT).as_posix()
    if name not in PAGES:
        return "the anchor is in no page"
    return "" if all(anchor in anchors for anchors in list_anchors(name)) else "the heading does not exist"


@pytest.mark.parametrize("page", [page for page, text in PAGES.items() if list_links(text)])
def test_links_of_a_page_exist(page: str) -> None:
    mistakes = {link: find_mistake(page, link) for link in list_links(PAGES[page])}
    assert {link: mistake for link, mistake in mistakes.items() if mistake} == {}


def test_pages_of_a_new_project_have_no_links_into_this_repository() -> None:
    assert {page: links for page in PAGES if page.startswith(TEMPLATES) and (links := list_links(PAGES[page]))} == {}


@pytest.mark.parametrize(
    "link, mistake",
    [
        ("no-such-page.md", "the file does not exist"),
        ("cli.md#no-such-heading", "the heading does not exist"),
        ("#no-such-heading", "the heading does not exist"),
        ("images/green-search.png#top", "the anchor is in no page"),
        ("../CONTRIBUTING.md#add-a-driver", ""),
        ("kinds.md#add-a-kind", ""),
    ],
)
def test_wrong_link_is_found(link: str, mistake: str) -> None:
    assert list_links(f"See [the page]({link}), not `[a](b)`.") == [link]
    assert find_mistake("docs/apps.md", link) == mistake


def test_messages_and_shipped_files_name_pages_by_their_titles() -> None:
    pages = [*PAGES.values(), *(text for _, text in list_plugin_pages())]
    titles = {text.partition("\n")[0].removeprefix("# ") for text in pages}
    shipped = [file for folder in ("robotcore", "drivers", "apps") for file in (ROOT / folder).rglob("*.*")]
    texts = {file: file.read_text(encoding="utf-8") for file in shipped if file.suffix in {".py", ".toml"}}
    texts[NOTES] = NOTES.read_text(encoding="utf-8").replace('\\"', '"')
    named = {(file, title) for file, text in texts.items() for title in re.findall(r'\bpage "([^"]+)"', text)}
    assert len(named) > 10
    assert {(file, title) for file, title in named if title not in titles} == set()
    assert [file for file, text in texts.items() if re.search(r"\bdocs/[\w-]+\.md", text)] == []
