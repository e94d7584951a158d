"""Pages: length of the README, links, tables that equal their files."""

import pathlib
import re
import sys

import pytest
from common import ended

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "pkg" / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def prose(page):
    return re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.M | re.S)


def anchors(page):
    """Anchors of its headings, as GitHub and Sphinx make them."""
    titles = re.findall(r"^#+ (.*)$", prose(page), re.M)
    return {re.sub(r"[^\w\- ]", "", re.sub(r"[`*]", "", title)).strip().lower().replace(" ", "-")
            for title in titles}


def test_readme_is_short():
    lines = (ROOT / "README.md").read_text().splitlines()
    assert len(lines) <= 120
    assert not [line for line in lines if len(line) > 120]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_resolve(page):
    text = prose(page)
    targets = re.findall(r"\]\(([^)\s]+)\)", text) + re.findall(r"^\[[^]]+\]: (\S+)$", text, re.M)
    for target in targets:
        if re.match(r"https?://", target):
            continue
        path, _, anchor = target.partition("#")
        other = (page.parent / path).resolve() if path else page
        assert other.is_file(), f"{target} is not there"
        assert not anchor or anchor in anchors(other), f"{target}: no such heading"
    named = set(re.findall(r"\]\[([\w-]+)\]", text))
    addresses = set(re.findall(r"^\[([^]]+)\]: ", text, re.M))
    assert named <= addresses, "a named link without its address"


def test_every_page_is_in_the_contents():
    docs = ROOT / "docs"
    contents = re.findall(r"^([\w/-]+)$", (docs / "index.md").read_text(), re.M)
    pages = {str(page.relative_to(docs).with_suffix("")) for page in docs.rglob("*.md")
             if not page.is_relative_to(docs / "results")}
    assert pages - {"index", *contents} == set()


def test_tables_are_those_of_their_files():
    ended(sys.executable, ROOT / "docs" / "generate" / "tables.py", "--check", timeout=120)


def test_readme_counts_the_statements_that_agree():
    verdicts = re.findall(r"\| (agrees|does not agree|not tested) \|$",
                          (ROOT / "docs" / "study" / "statements.md").read_text(), re.M)
    agree, total = re.search(r"(\d+) of\s+the\s+\[(\d+)\s+statements\]",
                             (ROOT / "README.md").read_text()).groups()
    assert (verdicts.count("agrees"), len(verdicts)) == (int(agree), int(total))
