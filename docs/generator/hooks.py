"""Hooks of MkDocs: they add the generated pages of the reference, and the pages outside of docs/."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

from docs.generator.api_pages import list_api_pages
from docs.generator.browser_files import list_browser_files
from docs.generator.command_pages import list_command_pages
from docs.generator.error_pages import list_error_pages
from docs.generator.notebook_pages import list_notebook_pages
from docs.generator.plugin_pages import list_plugin_pages
from docs.generator.repository_pages import DOCS, find_repository_pages, read_repository_page, rewrite_links

PAGES: dict[str, Callable[[], Iterator[tuple[str, str | bytes]]]] = {
    "browser": list_browser_files,
    "reference": list_plugin_pages,
    "reference/api": list_api_pages,
    "reference/commands": list_command_pages,
    "reference/errors": list_error_pages,
    "notebooks": list_notebook_pages,
}
"""The functions that yield the names and the contents of pages, by their folders on the site."""

BOOSTS = {
    "decisions/": 0.3,
    "quality/": 0.3,
    "reference/": 1.0,
    "changelog": 0.3,
    "measurements": 0.3,
    "system-tests": 0.3,
}
"""The weight of pages in a search, by the beginnings of their paths. The others are tutorials and guides."""

GUIDE_BOOST = 2.0

_site_paths = find_repository_pages()


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages, and those of files outside of docs/."""
    for source, site_path in _site_paths.items():
        files.append(File.generated(config, site_path, content=read_repository_page(source)))
    for folder, list_pages in PAGES.items():
        for name, content in list_pages():
            files.append(File.generated(config, f"{folder}/{name}", content=content))
    return files


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Return a page whose links lead to the pages of the site."""
    site_path = page.file.src_uri
    boost = next((boost for start, boost in BOOSTS.items() if site_path.startswith(start)), GUIDE_BOOST)
    page.meta.setdefault("search", {"boost": boost})
    source = next((source for source, each in _site_paths.items() if each == site_path), f"{DOCS}/{site_path}")
    return rewrite_links(markdown, source, site_path, _site_paths)
