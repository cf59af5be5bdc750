"""What documents say is so."""

import ast
import re
import runpy
import tomllib
from pathlib import Path

import pytest

import trackweave
from trackweave.cli.app import app
from trackweave.config.schema import tables
from trackweave.config.search import options_of
from trackweave.config.sections import ConfigurationSection
from trackweave.formats.registry import formats
from trackweave.keys import Key
from trackweave.solvers import METHODS

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
TEST_COMMAND = "python3 -m pip install -e '.[test]' && python3 -m pytest"
DEMO_COMMAND = "python3 -m pip install . && trackweave demo"


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(), flags=re.DOTALL)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)#]+)\)", page.read_text())
    local = [link for link in links if not link.startswith(("http:", "https:"))]
    assert [link for link in local if not (page.parent / link).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_examples_are_python_and_toml_and_use_public_names(page: Path) -> None:
    for code in blocks(page, "python"):
        names = {
            node.attr
            for node in ast.walk(ast.parse(code))
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "tw"
        }
        assert names <= set(trackweave.__all__)
    for text in blocks(page, "toml"):
        assert tomllib.loads(text)


def test_every_key_of_the_configuration_is_explained() -> None:
    page = (ROOT / "docs/reference/configuration.md").read_text()
    definitions = tables()[1].values()
    keys = {key for section in definitions for key in section["properties"]} - {"x", "y", "z"}
    assert len(keys) > 20
    assert {key for key in keys if f"`{key}" not in page} == set()


def rows(page: str) -> dict[str, str]:
    """Return the range of each key of the configuration's page, by its table and itself."""
    found, table = {}, ""
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        heading = re.match(r"\*\*`\[([a-z.]+)", cells[0])
        table = heading[1].rstrip(".") if heading else table
        for key in re.findall(r"`([a-z_]+)`", cells[0]) if len(cells) > 2 else ():
            found[f"{table}.{key}"] = cells[1]
    return found


def limits() -> dict[str, set[float]]:
    """Return each key's limits, by its table and itself."""
    found = {}
    for name, table in ConfigurationSection.as_kind(Key()).entries.items():
        inner = getattr(table.kind, "others", None) or table.kind
        for key, entry in getattr(inner, "entries", {}).items():
            schema = entry.kind.schema({})
            found[f"{name}.{key}"] = {schema.get("minimum"), schema.get("maximum")} - {None}
    return found


def test_the_page_of_the_configuration_says_each_keys_range() -> None:
    page = rows((ROOT / "docs/reference/configuration.md").read_text())
    checked = 0
    for place, ends in limits().items():
        said = page[place] if ends else ""
        numbers = {float(number) for number in re.findall(r"-?\d[\de.-]*\d|-?\d", said)}
        if "1 − 1e-12" in said or "no nearer than 1e-12" in said:
            numbers |= {1 - 1e-12}
        if said != "the same":
            assert ends <= numbers, place
            checked += len(ends)
    assert checked > 60


def test_the_page_that_the_code_makes_has_every_key_option_and_format() -> None:
    page = runpy.run_path(str(ROOT / "docs/every_key.py"))["page"]()
    parts = dict(re.findall(r"^##+ `?\[?([\w.-]+)\]?`?$\n(.*?)(?=^##|\Z)", page, re.M | re.S))
    for name, table in ConfigurationSection.as_kind(Key()).entries.items():
        inner = getattr(table.kind, "others", None) or table.kind
        place = f"{name}.NAME" if inner is not table.kind else name
        for key, entry in getattr(inner, "entries", {}).items():
            is_row = f"| `{key}` |" in parts[place] and entry.meaning
            assert is_row or f"{place}.{key}" in parts, place
    for method in METHODS:
        assert all(f"| `{option}` |" in parts[method] for option in options_of(method).entries)
    assert all(f"| `{name}` |" in parts["Formats"] for name in formats())
    assert "|  |" not in page


def test_every_solver_is_explained() -> None:
    page = (ROOT / "docs/choosing-a-solver.md").read_text()
    assert [method for method in METHODS if f"`{method}`" not in page] == []


def test_every_command_is_explained() -> None:
    page = (ROOT / "docs/reference/commands.md").read_text()
    commands = [
        command.callback.__name__ for command in app.registered_commands if command.callback
    ]
    assert len(commands) >= 7
    assert [name for name in commands if f"`trackweave {name}" not in page] == []


def test_every_decision_is_listed() -> None:
    folder = ROOT / "docs/decisions"
    listed = (folder / "README.md").read_text()
    pages = sorted(page.name for page in folder.glob("0*.md"))
    assert [page for page in pages if f"({page})" not in listed] == []
    assert [int(page[:4]) for page in pages] == list(range(1, len(pages) + 1))


def test_the_readmes_first_screen_has_both_commands_and_a_picture() -> None:
    first = "\n".join((ROOT / "README.md").read_text().splitlines()[:30])
    assert DEMO_COMMAND in first
    assert TEST_COMMAND in first
    assert "![" in first


def test_continuous_integration_runs_the_readmes_test_command_last() -> None:
    lines = (ROOT / ".ci/run").read_text().strip().splitlines()
    assert lines[-1] == TEST_COMMAND
    assert "scripts/check" in lines
