"""Pages of the site whose files lie outside of docs/: notes on quality, the changelog, and source files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from posixpath import dirname, join, normpath, relpath

ROOT = Path(__file__).resolve().parents[2]
DOCS = "docs"
FIXED = {
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "tests/system/README.md": "system-tests.md",
}
"""The paths on the site of files of the repository."""

LINK = re.compile(r"(\]\(\s*)([^()#\s]+)((?:#[^()\s]*)?\))")
FILE_LINK = re.compile(r"\[`?[\w./-]+\.md`?\](?=\(\s*([^()#\s]+\.md))")
"""Matches the text of a link to a page if it is the page's file, and its target."""

FENCE = re.compile(r"(^ *```.*?^ *```$)", re.MULTILINE | re.DOTALL)
NOT_SEARCHED = "---\nsearch:\n  exclude: true\n---\n"
"""The head of a page of source, which the search does not list."""

LANGUAGES = {".py": "python", ".toml": "toml", ".ino": "cpp", ".h": "cpp", ".cpp": "cpp"}


def find_repository_pages() -> dict[str, str]:
    """Return the paths on the site of all linked files outside of docs/, by their paths in the repository."""
    site_paths = dict(FIXED)
    rest = [*(path.relative_to(ROOT).as_posix() for path in sorted((ROOT / DOCS).rglob("*.md"))), *FIXED]
    while rest:
        page = rest.pop()
        for target in _list_targets(page):
            if not target.startswith((DOCS, "..")) and target not in site_paths and (ROOT / target).exists():
                site_paths[target] = _choose_site_path(target)
                rest += [target] if target.endswith(".md") else []
    return site_paths


def read_repository_page(source: str) -> str:
    """Return the Markdown of a file outside of docs/. A file of source becomes a listing."""
    path = ROOT / source
    if path.is_dir():
        parts = [f"## {file.name}\n\n{_format_listing(file)}" for file in sorted(path.iterdir()) if file.is_file()]
        return NOT_SEARCHED + "\n\n".join([f"# {source}", *parts]) + "\n"
    if path.suffix == ".md":
        return path.read_text(encoding="utf-8")
    return f"{NOT_SEARCHED}# {source}\n\n{_format_listing(path)}\n"


def rewrite_links(markdown: str, source: str, site_path: str, site_paths: dict[str, str]) -> str:
    """Return a page whose links lead to the pages of the site, and have their titles in place of file names.

    source: the page's path in the repository.
    site_path: its path on the site, from the site's root.
    site_paths: the paths on the site of files outside of docs/, by their paths in the repository.
    """

    def rewrite(link: re.Match[str]) -> str:
        target = normpath(join(dirname(source), link[2]))
        if "://" in link[2] or link[2].startswith("mailto:"):
            return link[0]
        if (ROOT / target / "README.md").exists() and target.startswith(DOCS):
            target = f"{target}/README.md"
        if target == "README.md":
            target = f"{DOCS}/index.md"
        new = site_paths.get(target) or (relpath(target, DOCS) if target.startswith(f"{DOCS}/") else None)
        return f"{link[1]}{relpath(new, dirname(site_path) or '.')}{link[3]}" if new else link[0]

    def name_by_title(link: re.Match[str]) -> str:
        file = ROOT / normpath(join(dirname(source), link[1]))
        return f"[{_read_title(file)}]" if file.exists() else link[0]

    parts = FENCE.split(markdown)
    return "".join(
        part if number % 2 else LINK.sub(rewrite, FILE_LINK.sub(name_by_title, part))
        for number, part in enumerate(parts)
    )


def _read_title(page: Path) -> str:
    return page.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")


def _list_targets(page: str) -> Iterator[str]:
    for _, target, _ in LINK.findall(FENCE.sub("", (ROOT / page).read_text(encoding="utf-8"))):
        if "://" not in target:
            yield normpath(join(dirname(page), target))


def _choose_site_path(source: str) -> str:
    if source.endswith("QUALITY.md"):
        return f"quality/{dirname(source).replace('drivers/', '').replace('/', '-')}.md"
    return f"source/{source.removesuffix('.md').replace('.', '_')}.md"


def _format_listing(file: Path) -> str:
    return f"````{LANGUAGES.get(file.suffix, 'text')}\n{file.read_text(encoding='utf-8').rstrip()}\n````"
