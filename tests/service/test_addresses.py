"""Who may be listened to."""

import pytest

from trackweave.errors import InvalidInputError
from trackweave.service.addresses import checked_listening, is_loopback, shown_address


@pytest.mark.parametrize("host", ["127.0.0.1", "127.9.9.9", "::1", "localhost"])
def test_this_machine_needs_neither_token_nor_tls(host: str) -> None:
    assert is_loopback(host)
    checked_listening(host, has_token=False, has_tls=False)


@pytest.mark.parametrize(
    "host", ["0.0.0.0", "", "::", "192.0.2.1", "::ffff:192.0.2.1", "fe80::1%1", "no such host"]
)
def test_other_machines_need_both(host: str) -> None:
    assert not is_loopback(host)
    checked_listening(host, has_token=True, has_tls=True)
    for has_token, has_tls, missing in (
        (False, False, "--token-file and --certificate"),
        (True, False, "without --certificate and --key"),
        (False, True, "without --token-file"),
    ):
        with pytest.raises(InvalidInputError, match=missing):
            checked_listening(host, has_token=has_token, has_tls=has_tls)


def test_addresses_are_shown_as_in_urls() -> None:
    assert shown_address("::1", 80) == "[::1]:80"
    assert shown_address("127.0.0.1", 80) == "127.0.0.1:80"
