"""Files of tokens, and what of them is kept."""

from pathlib import Path

import pytest

from trackweave.errors import InvalidInputError
from trackweave.service.web.tokens import line_of, new_token, read_tokens


def test_tokens_open_whether_hashed_or_in_clear_and_only_digests_are_kept(tmp_path: Path) -> None:
    one, other = new_token(), "in clear and long enough"
    file = tmp_path / "tokens"
    file.write_text(f"# two\n{line_of(one, 'radar')}\n\n{other}\r\n")
    found = read_tokens(file)
    assert found.matches(one)
    assert found.matches(other)
    assert not any(found.matches(wrong) for wrong in ("", "x", one[:-1], line_of(one), one + " "))
    assert one not in file.read_text()
    assert one not in repr(found)
    assert other not in repr(found)
    assert not found.has_short


def test_notes_say_where_a_file_gives_tokens_away(tmp_path: Path) -> None:
    file = tmp_path / "tokens"
    file.write_text("secret")
    file.chmod(0o644)
    found = read_tokens(file)
    assert found.matches("secret")
    assert found.has_short
    notes = " ".join(found.notes)
    assert all(word in notes for word in ("in clear", "mode 600", "guessed"))
    file.write_text(line_of(new_token()))
    assert read_tokens(file).notes == ()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "no token"),
        (b"# nothing\n\n", "no token"),
        (b"sha256:abc", "expected 64 digits"),
        (b"\xff\xfe", "not UTF-8"),
        ("schlüssel-mit-umlaut".encode(), "ASCII"),
        (b"x" * 70_000, "64 KiB"),
    ],
)
def test_a_file_without_tokens_is_refused_without_showing_it(
    tmp_path: Path, content: bytes, said: str
) -> None:
    file = tmp_path / "tokens"
    file.write_bytes(content)
    with pytest.raises(InvalidInputError, match=said) as refused:
        read_tokens(file)
    assert "umlaut" not in str(refused.value)


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "none", tmp_path, Path("a\0b")):
        with pytest.raises(InvalidInputError):
            read_tokens(path)
