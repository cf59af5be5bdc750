"""The list of formats, and what is said of them."""

from pathlib import Path

from trackweave.formats.registry import formats

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "formats.md"


def test_every_format_is_explained():
    page = PAGE.read_text()
    assert [name for name in formats() if f"`{name}`" not in page] == []
    options = [option.name for each in formats().values() for option in each.options]
    assert [name for name in options if f"`{name}=" not in page] == []


def test_formats_read_or_write_and_say_what_they_carry():
    for each in formats().values():
        assert each.can_read or each.writer is not None
        assert each.carries
        assert each.loses
        assert each.can_read == (each.recognise is not None)


def test_the_example_of_a_format_works():
    code = PAGE.read_text().partition("```python\n")[2].partition("```")[0]
    names: dict = {}
    exec(code, names)
    decoder = names["FORMAT"].decoder()
    assert decoder.feed(b"0.0 100 45\n1.0 9") is not None
    assert decoder.feed(b"9 46\n")["range_m"].to_list() == [99.0]
