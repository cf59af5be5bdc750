"""What the site is made of is whole: names, gallery, tutorials, and what is said twice."""

import ast
import re
import runpy
import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest

import trackweave
import trackweave.metrics
import trackweave.simulation

ROOT = Path(__file__).resolve().parents[2]
GALLERY = sorted((ROOT / "examples" / "gallery").glob("*/*.py"))


def listed(module: str) -> list[str]:
    """Return the names that the reference lists of a module, in its order."""
    page = (ROOT / "docs/reference/api.md").read_text()
    blocks = re.findall(rf"currentmodule:: {re.escape(module)}\n(.*?)```", page, flags=re.DOTALL)
    return [name for block in blocks for name in re.findall(r"^   (\w+)$", block, re.MULTILINE)]


def test_the_reference_lists_every_public_name_once() -> None:
    names = set(trackweave.__all__) - {"__version__"}
    assert sorted(listed("trackweave")) == sorted(names)


@pytest.mark.parametrize("module", [trackweave.simulation, trackweave.metrics])
def test_the_reference_lists_every_name_of_a_public_package(module: object) -> None:
    names = module.__all__  # type: ignore[attr-defined]
    # What the library offers by the same name has its page there.
    own = [n for n in names if getattr(module, n) is not getattr(trackweave, n, None)]
    assert sorted(listed(module.__name__)) == sorted(own)  # type: ignore[attr-defined]


def test_the_gallery_has_twenty_examples_and_more() -> None:
    assert len(GALLERY) >= 20
    configuration = (ROOT / "docs/conf.py").read_text()
    names = {name for example in GALLERY for name in (example.parent.name, example.stem)}
    assert [name for name in names if f'"{name}"' not in configuration] == []


@pytest.mark.parametrize("example", GALLERY, ids=lambda example: example.stem)
def test_an_example_has_a_title_a_picture_and_no_chance(example: Path) -> None:
    text = example.read_text()
    tree = ast.parse(text)
    title, line = (ast.get_docstring(tree) or "").splitlines()[:2]
    assert line == "=" * len(title)
    assert text.rstrip().endswith(f'figure.savefig("{example.stem}.png")')
    assert len(text.splitlines()) <= 100
    # Without a seed a generator draws other numbers each time.
    assert "default_rng()" not in text
    names = {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "tw"
    }
    assert names <= set(trackweave.__all__)


def test_the_citation_names_the_version() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert f"version: {project['version']}\n" in (ROOT / "CITATION.cff").read_text()


def test_no_address_is_said_in_two_places() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for address in project.get("urls", {}).values():
        assert address not in (ROOT / "docs/conf.py").read_text()


def test_continuous_integration_builds_the_site() -> None:
    assert "scripts/docs --quick" in (ROOT / ".ci/run").read_text()
    assert "scripts/docs\n" in (ROOT / ".github/workflows/docs.yml").read_text()


def test_what_is_returned_stands_on_one_line() -> None:
    pytest.importorskip("sphinx_gallery")
    joined = runpy.run_path(str(ROOT / "docs/conf.py"))["joined"]
    lines = [
        "Track.",
        "",
        "Returns",
        "-------",
        "Tracks, and",
        "the record.",
        "",
        "Raises",
        "------",
    ]
    joined("function", "track", lines)
    assert lines == [*lines[:4], "Tracks, and the record.", "", "Raises", "------"]


def test_links_into_a_page_stay_links_and_those_to_the_gallery_lead_there() -> None:
    pytest.importorskip("sphinx_gallery")
    lead = runpy.run_path(str(ROOT / "docs/conf.py"))["lead_into_the_site"]
    app = SimpleNamespace(env=SimpleNamespace(doc2path=lambda name: f"{name}.md"))
    source = ["[there](#here), [all](../examples/gallery) and [folders](images)"]
    lead(app, "index", source)
    assert source == ["[there](#here), [all](gallery/index.rst) and folders"]


def test_tables_scroll_in_a_box_on_explanations_alone() -> None:
    static = ROOT / "docs/_static"
    assert "max-height" not in (static / "site.css").read_text()
    assert "max-height" in (static / "boxes.css").read_text()
