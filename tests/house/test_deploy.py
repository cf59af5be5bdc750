"""What is deployed runs the program that there is."""

import configparser
import re
from pathlib import Path

import typer

from trackweave.cli.app import app

ROOT = Path(__file__).resolve().parents[2]
SHOWN = [
    *sorted((ROOT / "deploy").iterdir()),
    ROOT / "docs/how-to/live-behind-a-proxy.md",
    ROOT / "docs/explanation/service-security.md",
]


def options_of(name: str) -> set[str]:
    command = typer.main.get_command(app).commands[name]
    return {option for each in command.params for option in each.opts}


def test_every_option_that_is_shown_is_one_of_serve() -> None:
    known = options_of("serve") | options_of("token")
    found = 0
    for page in SHOWN:
        for line in re.findall(
            r"trackweave (?:serve|token)((?:[^\n`]*\\\n)*[^\n`]*)", page.read_text()
        ):
            told = set(re.findall(r"(?<!\S)--[a-z-]+", line.partition("#")[0]))
            assert told <= known, (page, told - known)
            found += len(told)
    assert found >= 8


def test_the_unit_ends_later_than_the_service_does_and_owns_nothing_else() -> None:
    text = (ROOT / "deploy/trackweave.service").read_text()
    unit = configparser.ConfigParser(strict=False, interpolation=None)
    unit.optionxform = str  # type: ignore[assignment, method-assign]
    unit.read_string(text)
    service = unit["Service"]
    assert float(service["TimeoutStopSec"]) > 2
    assert service["ProtectSystem"] == "strict"
    assert service["DynamicUser"] == service["NoNewPrivileges"] == "yes"
    assert f"--data /var/lib/{service['StateDirectory']}" in text
