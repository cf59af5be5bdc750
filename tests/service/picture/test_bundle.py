"""The page's modules, and that they may stand in one script."""

import re
from collections import Counter
from importlib.resources import files

import pytest

from trackweave.service.picture.bundle import bundled, file_of_page

FOLDER = files("trackweave.service") / "page"
MODULES = sorted(file.name for file in FOLDER.iterdir() if file.name.endswith(".js"))
DEFINED = re.compile(
    r"^(?:export )?(?:async )?(?:function|class|const|let) (\w+|\[[^\]]+\])", re.M
)
TEXT_FILES = [*MODULES, "page.css", "index.html"]


def names_of(text: str) -> list[str]:
    return [name for found in DEFINED.findall(text) for name in re.findall(r"\w+", found)]


@pytest.mark.parametrize("entry", ["picture.js", "live.js"])
def test_no_two_modules_of_a_script_define_one_name(entry: str) -> None:
    counts = Counter(names_of(bundled(entry)))
    assert len(counts) > 60
    assert [name for name, count in counts.items() if count > 1] == []


@pytest.mark.parametrize("entry", ["picture.js", "live.js"])
def test_nothing_is_imported_or_exported_any_more(entry: str) -> None:
    assert re.findall(r"^(?:import|export)\b.*", bundled(entry), re.M) == []


@pytest.mark.parametrize("name", MODULES)
def test_modules_import_what_others_export(name: str) -> None:
    pattern = r'import \{([^}]*)\} from "\./([a-z]+\.js)";'
    for wanted, other in re.findall(pattern, file_of_page(name)):
        exported = re.findall(
            r"^export (?:async )?(?:function|class|const) (\w+|\[[^\]]+\])",
            file_of_page(other),
            re.M,
        )
        assert set(re.findall(r"\w+", wanted)) <= set(re.findall(r"\w+", " ".join(exported)))


@pytest.mark.parametrize("name", MODULES)
def test_no_module_makes_markup_or_code_of_text(name: str) -> None:
    forbidden = (
        r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\b|new Function|srcdoc"
    )
    assert re.findall(forbidden, file_of_page(name)) == []


@pytest.mark.parametrize("name", TEXT_FILES)
def test_the_page_names_no_other_origin(name: str) -> None:
    # The name of a language that drawings are in is fetched by nobody.
    text = file_of_page(name).replace("http://www.w3.org/2000/svg", "")
    assert re.findall(r"(?:https?:)?//[\w.-]+\.\w{2,}", text) == []
    assert "@import" not in text


@pytest.mark.parametrize("name", TEXT_FILES)
def test_no_file_of_the_page_is_longer_than_four_hundred_lines(name: str) -> None:
    assert len(file_of_page(name).splitlines()) <= 400
