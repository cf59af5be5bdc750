"""Kernels that came with the package are used where they fit, and nowhere else."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from llvmlite import binding

import trackweave
from trackweave.kernel_cache import FOLDER, STAMP, name_of
from trackweave.warming.packing import kernels

pytestmark = pytest.mark.slow

SOURCE = Path(trackweave.__file__).parent
# One kernel by itself, and one within which numba's own power of integers may raise.
USE = """
import numpy as np
from trackweave.association._rhythm import _odds
from trackweave.filters._kernels import squared_distance
found = squared_distance(np.array([3.0, 4.0]), np.zeros(2), np.eye(2))
odds = _odds(np.array([0.0, 0.0, 1.0, 0.5, 3.0]), 5.0, 2)
"""
PACK = f"""
import sys
from pathlib import Path
from trackweave.warming.packing import forget_places, pack
forget_places()
{USE}
pack(Path(sys.argv[1]))
"""
TELL = f"""
import json
from trackweave.kernel_cache import why_not_shipped
{USE}
came = squared_distance._cache.came + _odds._cache.came
print(json.dumps([found, float(odds), dict(came), why_not_shipped()]))
"""


def run(code, package, cache, *arguments, **environment):
    """Run code with a copy of the package, and another folder for what numba keeps."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code, *map(str, arguments)],
        env=os.environ
        | {"PYTHONPATH": str(package.parent), "NUMBA_CACHE_DIR": str(cache)}
        | environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def tell(package, cache, **environment):
    return json.loads(run(TELL, package, cache, **environment))


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Return a copy of the package that two kernels came with."""
    place = tmp_path_factory.mktemp("built")
    package = place / "site" / "trackweave"
    shutil.copytree(SOURCE, package, ignore=shutil.ignore_patterns("__pycache__", FOLDER.name))
    run(PACK, package, place / "cache", package / FOLDER.name)
    return package


@pytest.fixture
def package(built, tmp_path):
    """Return a copy of that copy, to be spoilt."""
    return Path(shutil.copytree(built, tmp_path / "site" / "trackweave"))


def test_uses_what_came_with_the_package_and_keeps_nothing(built, tmp_path):
    found, odds, came, why_not = tell(built, tmp_path / "cache")
    assert (found, came, why_not) == (25.0, {"shipped": 2}, None)
    assert list(tmp_path.rglob("*.nbc")) == []
    # The same as compiled here, which is what the tests do everywhere else.
    bare = shutil.copytree(built, tmp_path / "bare" / "trackweave")
    shutil.rmtree(bare / FOLDER.name)
    assert tell(bare, tmp_path / "cache")[:3] == [found, odds, {"compiled": 2}]


def test_a_kernel_that_is_compiled_here_takes_in_one_that_came(built, tmp_path):
    code = """
import json
import numba, numpy as np
from trackweave.filters._kernels import squared_distance
@numba.njit
def twice(where):
    return 2.0 * squared_distance(where, np.zeros(2), np.eye(2))
print(json.dumps([twice(np.array([3.0, 4.0])), dict(squared_distance._cache.came)]))
"""
    assert json.loads(run(code, built, tmp_path / "cache")) == [50.0, {"shipped": 1}]


def test_a_kernel_without_its_function_is_compiled(package, tmp_path):
    code = """
import pickle, sys
from pathlib import Path
for file in Path(sys.argv[1]).glob("*.kernel"):
    versions = pickle.loads(file.read_bytes())
    for types, payload in versions.items():
        library, described, *rest = pickle.loads(payload)
        described.mangled_name += "x"
        versions[types] = pickle.dumps((library, described, *rest))
    file.write_bytes(pickle.dumps(versions))
"""
    run(code, package, tmp_path / "none", package / FOLDER.name)
    assert tell(package, tmp_path / "cache")[2] == {"compiled": 2}


def test_an_edit_of_what_a_kernel_imports_makes_it_compile(package, tmp_path):
    imported = package / "arrays.py"
    imported.write_text(imported.read_text() + "# edited\n")
    cache = tmp_path / "cache"
    assert tell(package, cache)[2:] == [{"compiled": 2}, "made of other sources"]
    assert tell(package, cache)[2] == {"kept": 2}
    imported.write_text(imported.read_text() + "# again\n")
    assert tell(package, cache)[2] == {"compiled": 2}


@pytest.mark.parametrize("key", ["python", "numba", "llvmlite", "platform"])
def test_another_compiler_or_machine_compiles(package, tmp_path, key):
    stamp = json.loads((package / FOLDER.name / STAMP).read_text())
    stamp["machine"][key] = "another"
    (package / FOLDER.name / STAMP).write_text(json.dumps(stamp))
    found, _, came, why_not = tell(package, tmp_path / "cache")
    assert (found, came) == (25.0, {"compiled": 2})
    assert why_not.startswith(f"made for {key} another, not ")


@pytest.mark.parametrize("what", [b"", b"no pickle", None])
def test_a_damaged_kernel_is_compiled_in_silence(package, tmp_path, what):
    for file in (package / FOLDER.name).glob("*.kernel"):
        file.write_bytes(file.read_bytes()[:-100] if what is None else what)
    assert tell(package, tmp_path / "cache")[2] == {"compiled": 2}


@pytest.mark.parametrize("what", ["", "[]", '{"machine": 3}', "{}"])
def test_a_damaged_stamp_is_taken_for_none(package, tmp_path, what):
    (package / FOLDER.name / STAMP).write_text(what)
    _, _, came, why_not = tell(package, tmp_path / "cache")
    assert came == {"compiled": 2}
    assert "cannot be read" in why_not


def test_who_asks_numba_for_other_code_gets_it(built, tmp_path):
    _, _, came, why_not = tell(built, tmp_path / "cache", NUMBA_BOUNDSCHECK="1")
    assert (came, why_not) == ({"compiled": 2}, "NUMBA_BOUNDSCHECK asks for other code")


def test_holds_no_path_of_the_machine_that_built_it(built):
    places = [str(built.parent.parent), sys.prefix, str(Path(trackweave.__file__).parents[2])]
    places += [str(Path(binding.__file__).parents[2]), str(Path.home())]
    code = """
import pickle, sys
from pathlib import Path
from llvmlite import binding
texts = []
for file in Path(sys.argv[1]).glob("*.kernel"):
    for payload in pickle.loads(file.read_bytes()).values():
        library = pickle.loads(payload)[0]
        texts += [str(binding.parse_bitcode(library[2][1])), library[2][0].decode("latin-1")]
print("".join(texts))
"""
    folder = built / FOLDER.name
    texts = [file.read_bytes().decode("latin-1") for file in folder.iterdir()]
    # Bitcode packs its characters.
    texts.append(run(code, built, built.parent / "none", folder, PYTHONIOENCODING="utf-8"))
    assert [place for place in places for text in texts if place in text] == []
    assert "numbers.py" in "".join(texts)


def test_loads_without_the_compilers_own_tables(built):
    assert json.loads((built / FOLDER.name / STAMP).read_text())["alone"] is True


def test_each_kernel_has_a_file_of_its_own_inside_the_package():
    names = [name_of(function) for function, _ in kernels()]
    assert len(names) > 200
    assert len(set(names)) == len(names)
    assert FOLDER.parent == SOURCE
    assert {Path(name).name for name in names} == set(names)
