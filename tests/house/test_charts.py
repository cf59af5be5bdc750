"""What the pages on the source documents name is there: files, tests, symbols, figures."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src" / "trackweave"
PAGES = [
    page
    for name in ("hillis-1997", "huo-2008", "wiranto-2018")
    if (page := ROOT / "docs" / "explanation" / f"{name}.md").exists()
]
PYTHON = sorted([*SOURCE.rglob("*.py"), *(ROOT / "examples").glob("*.py")])
IN_A_FILE = re.compile(r"([\w./-]+\.py)(?:::?([\w.]+(?:::\w+)?))?")


def cells(page: Path) -> list[tuple[str, str]]:
    """Return the head of its column and the text of each cell of a page's tables."""
    found, heads = [], []
    for line in page.read_text().splitlines():
        if not line.startswith("|"):
            heads = []
            continue
        row = [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1]]
        if not heads:
            heads = row
        elif not set("".join(row)) <= set(" :-"):
            found += list(zip(heads, row, strict=True))
    return found


def is_defined(name: str, texts: list[str]) -> bool:
    last = name.replace("::", ".").rpartition(".")[2]
    defined = re.compile(rf"^\s*(?:def|class) {last}\b|^\s*{last}\b\s*[:=]", re.MULTILINE)
    return any(defined.search(text) for text in texts)


def resolves(token: str) -> bool:
    """Tell whether what a table names is there; a token of another kind names nothing."""
    in_file = IN_A_FILE.fullmatch(token)
    if in_file:
        path = next(
            (base / in_file[1] for base in (SOURCE, ROOT) if (base / in_file[1]).is_file()), None
        )
        return path is not None and (not in_file[2] or is_defined(in_file[2], [path.read_text()]))
    if re.fullmatch(r"test_\w+", token):
        return is_defined(token, [path.read_text() for path in (ROOT / "tests").rglob("*.py")])
    if re.fullmatch(r"\w+\.png", token):
        return any(token in path.read_text() for path in (SOURCE / "studies").glob("*.[pt]*"))
    return True


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_files_tests_and_figures_in_its_tables_are_there(page: Path) -> None:
    tokens = {token for _, cell in cells(page) for token in re.findall(r"`([^`]+)`", cell)}
    assert tokens
    assert sorted(token for token in tokens if not resolves(token)) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_symbols_in_a_column_of_code_are_there(page: Path) -> None:
    texts = [path.read_text() for path in PYTHON]
    names = {
        token
        for head, cell in cells(page)
        if head == "code"
        for token in re.findall(r"`([A-Za-z_][\w.]*)(?: = [^`]*)?`", cell)
        if not token.endswith((".py", ".png"))
    }
    found = [name for name in names if is_defined(name, texts) or in_presets(name)]
    assert sorted(names - set(found)) == []


def in_presets(key: str) -> bool:
    """Tell whether a preset says something of a key."""
    last = key.rpartition(".")[2]
    return any(f'"{last}"' in path.read_text() for path in (SOURCE / "presets").glob("*.py"))


@pytest.mark.parametrize(
    "token", ["solvers/genetics.py", "solvers/greedy.py:Greedier", "test_is_nowhere", "no.png"]
)
def test_what_is_not_there_is_told(token: str) -> None:
    assert not resolves(token)
