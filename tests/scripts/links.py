"""Links of the pages lead somewhere: python3 links.py

Exit status 77 (CTest: skipped) outside a git repository."""
from __future__ import annotations

import pathlib
import re
import unittest

from support import tracked

ROOT = pathlib.Path(__file__).resolve().parents[2]


def prose(text: str) -> str:
    """Without its blocks and spans of code."""
    text = re.sub(r"^( *)```.*?^\1```", "", text, flags=re.M | re.S)
    return re.sub(r"`[^`\n]*`", lambda code: re.sub(r"[\[\]()#]", "", code[0]), text)


def anchors(text: str) -> set[str]:
    """The names that GitHub gives to the headings of a page."""
    names: list[str] = []
    for heading in re.findall(r"^#{1,6} +(.*?) *#*$", prose(text), re.M):
        name = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        count = names.count(name)
        names.append(f"{name}-{count}" if count else name)
    return set(names)


def dead(page: pathlib.Path, text: str) -> list[str]:
    """The links of a page with this text that lead to no file, or to no heading of one."""
    links = re.findall(r"\]\(([^)\s]+)[^)]*\)", prose(text))
    links += re.findall(r"^ *\[[^\]]+\]: *(\S+)", prose(text), re.M)
    lost = []
    for link in links:
        if re.match(r"[a-z]+:", link):
            continue
        name, _, anchor = link.partition("#")
        target = page.parent / name
        if name and not target.exists():
            lost.append(link)
        elif anchor and anchor not in anchors(target.read_text() if name else text):
            lost.append(link)
    return lost


class Links(unittest.TestCase):
    def test_every_link_of_a_page_leads_somewhere(self) -> None:
        pages = tracked(ROOT, "*.md")
        self.assertIn(ROOT / "README.md", pages)
        for page in pages:
            with self.subTest(page=str(page.relative_to(ROOT))):
                self.assertEqual(dead(page, page.read_text()), [])

    def test_a_link_that_leads_nowhere_is_found(self) -> None:
        text = """# Two words: `-an_option`
## Two words: `-an_option`
[a](#two-words--an_option) [b](#two-words--an_option-1) [c](#three) [d](README.md)
[e](gone.md) [f](README.md#gone) [g](https://example.org) ![h](gone.png "title") `[i](gone)`
```
# No heading
[j](gone)
```
[k](#no-heading)
[l]: gone.txt
"""
        lost = ["#three", "gone.md", "README.md#gone", "gone.png", "#no-heading", "gone.txt"]
        self.assertEqual(dead(ROOT / "x.md", text), lost)


if __name__ == "__main__":
    unittest.main()
