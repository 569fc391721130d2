"""Check that every internal link of the built documentation leads somewhere: ``python docs/check_links.py HTML``.

Sphinx warns of broken references while it reads; this looks at what it wrote: links of themes, galleries and raw
HTML, pictures, downloads and anchors. Links to other sites are not followed.
"""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ADDRESSES = {"a": "href", "img": "src", "link": "href", "object": "data", "script": "src", "source": "src"}


class _Page(HTMLParser):
    """Collects what a page links to, and what can be linked to in it."""

    def __init__(self) -> None:
        super().__init__()
        self.links: set[str] = set()
        self.anchors: set[str] = {"", "top"}

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if value is None:
                continue
            if name == ADDRESSES.get(tag):
                self.links.add(value)
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value)


def broken_links(folder: Path) -> list[str]:
    """Return one sentence for every internal link of the HTML files in a folder that leads nowhere."""
    pages: dict[Path, _Page] = {}
    for path in sorted(folder.rglob("*.html")):
        page = pages[path.resolve()] = _Page()
        page.feed(path.read_text(encoding="utf-8"))
    found = []
    for path, page in pages.items():
        for link in sorted(page.links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            where = path.relative_to(folder.resolve())
            if not target.is_file():
                found.append(f"{where}: {link} is no file")
            elif target in pages and unquote(parts.fragment) not in pages[target].anchors:
                found.append(f"{where}: {link} is no place on that page")
    return found


def main(arguments: list[str]) -> int:
    """Print the broken links of one folder; return 1 when there are any, 2 when there is nothing to check."""
    folder = Path(*arguments)
    if not any(folder.rglob("*.html")):
        print(f"{folder} holds no HTML", file=sys.stderr)
        return 2
    found = broken_links(folder)
    print("\n".join(found) if found else "every internal link leads somewhere")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
