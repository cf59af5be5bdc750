"""Who is let in, by a real client of a real server."""

from collections.abc import Iterator

import httpx
import pytest
from websockets.exceptions import InvalidStatus

from oracles.serving import RememberingDesk, Serving, get, listen, post
from trackweave.service.web.settings import Limits, WebSettings
from trackweave.service.web.tokens import Tokens, line_of, new_token, read_tokens

TOKEN = new_token()
PATHS = ("/tracks", "/tracks/1", "/sensors", "/healthz", "/metrics", "/main.js", "/x")


def tokens(tmp_path_factory: pytest.TempPathFactory) -> Tokens:
    file = tmp_path_factory.mktemp("token") / "tokens"
    file.write_text(f"# who\n{line_of(TOKEN, 'radar')}\n")
    return read_tokens(file)


@pytest.fixture(scope="module")
def locked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Serving]:
    settings = WebSettings(
        tokens=tokens(tmp_path_factory), limits=Limits(failures_per_min=1000, per_address=500)
    )
    with Serving(RememberingDesk(), settings) as running:
        yield running


@pytest.fixture(scope="module")
def open_one() -> Iterator[Serving]:
    with Serving(RememberingDesk()) as running:
        yield running


def bearer(token: str = TOKEN) -> dict[str, str]:
    return {"authorization": f"Bearer {token}"}


@pytest.mark.parametrize("path", PATHS)
def test_nothing_is_shown_without_the_token(locked: Serving, path: str) -> None:
    for headers in ({}, bearer("wrong"), {"authorization": f"Basic {TOKEN}"}, bearer(TOKEN[:-1])):
        done = get(f"{locked.url}{path}", headers=headers)
        assert done.status_code == 401
        assert done.headers["www-authenticate"].startswith("Bearer")
        assert set(done.json()) == {"error"}
    assert get(f"{locked.url}{path}", headers=bearer()).status_code in (200, 404)


def test_no_report_gets_in_without_the_token(locked: Serving) -> None:
    line = '{"time": 1, "x": 1, "y": 1}'
    before = len(locked.desk.taken)
    for headers in ({}, bearer("wrong"), {"cookie": "trackweave=x"}, {"cookie": "trackweave="}):
        done = post(f"{locked.url}/reports", content=line, headers=headers)
        assert done.status_code == 401
    query = f"{locked.url}/reports?token={TOKEN}"
    assert post(query, content=line).status_code == 401
    assert len(locked.desk.taken) == before
    assert post(f"{locked.url}/reports", content=line, headers=bearer()).is_success


def test_two_tokens_at_once_are_none(locked: Serving) -> None:
    headers = [("authorization", f"Bearer {TOKEN}"), ("authorization", "Bearer wrong")]
    assert get(f"{locked.url}/tracks", headers=headers).status_code == 401


def test_the_page_sends_people_to_its_login_and_the_cookie_opens_it(locked: Serving) -> None:
    with httpx.Client(base_url=locked.url) as browser:
        first = browser.get("/", headers={"accept": "text/html"}, follow_redirects=True)
        assert first.url.path == "/login"
        assert "script" not in first.headers["content-security-policy"]
        assert browser.get("/login.css").is_success
        wrong = browser.post("/login", data={"token": "wrong"})
        assert (wrong.status_code, "Not a token" in wrong.text) == (401, True)
        done = browser.post("/login", data={"token": TOKEN})
        assert (done.status_code, done.headers["location"]) == (303, "/")
        cookie = done.headers["set-cookie"].lower()
        assert all(word in cookie for word in ("httponly", "samesite=strict", "path=/"))
        assert TOKEN not in done.headers["set-cookie"]
        assert browser.get("/").text.startswith("<!doctype html><title>map")
        kept = dict(browser.cookies)
        assert browser.post("/logout").status_code == 303
        assert get(f"{locked.url}/tracks", cookies=kept).status_code == 401


def test_who_guesses_too_often_must_wait_with_the_right_token_too(
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    settings = WebSettings(
        tokens=tokens(tmp_path_factory),
        limits=Limits(failures_per_min=0.01),
        proxies=("127.0.0.1",),
    )
    with Serving(RememberingDesk(), settings) as running:
        found = [
            get(f"{running.url}/tracks", headers=bearer("wrong")).status_code for _ in range(20)
        ]
        assert found == [401] + [429] * 19
        assert get(f"{running.url}/tracks", headers=bearer()).status_code == 429
        assert post(f"{running.url}/login", data={"token": TOKEN}).status_code == 401
        # Somebody else, of whom the proxy tells, need not.
        other = {**bearer(), "x-forwarded-for": "127.0.0.1, 203.0.113.7"}
        assert get(f"{running.url}/tracks", headers=other).is_success


def test_nobody_says_of_himself_who_he_is_where_there_is_no_proxy(
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    settings = WebSettings(tokens=tokens(tmp_path_factory), limits=Limits(failures_per_min=0.01))
    with Serving(RememberingDesk(), settings) as running:
        found = [
            get(
                f"{running.url}/tracks",
                headers={**bearer("wrong"), "x-forwarded-for": f"203.0.113.{k}"},
            ).status_code
            for k in range(10)
        ]
    assert found == [401] + [429] * 9


def test_requests_have_a_rate() -> None:
    with Serving(RememberingDesk(), WebSettings(limits=Limits(requests_per_s=0.001))) as running:
        found = [get(f"{running.url}/healthz").status_code for _ in range(5)]
    assert found == [200, 429, 429, 429, 429]


@pytest.mark.parametrize("host", ["evil.example", "localhost.evil.example", "1.2.3.4", "[::2]"])
def test_a_name_that_was_made_to_lead_here_is_refused(open_one: Serving, host: str) -> None:
    assert get(f"{open_one.url}/tracks", headers={"host": host}).status_code == 421


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1:9", "[::1]:80", "LOCALHOST:1"])
def test_this_machines_own_names_are_taken(open_one: Serving, host: str) -> None:
    assert get(f"{open_one.url}/tracks", headers={"host": host}).is_success


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "https://evil.example"},
        {"origin": "null"},
        {"origin": "http://localhost:1"},
        {"origin": "http://127.0.0.1"},
        {"origin": ""},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site", "origin": "http://localhost:1"},
    ],
)
def test_other_origins_can_neither_post_nor_listen(
    open_one: Serving, headers: dict[str, str]
) -> None:
    done = post(f"{open_one.url}/reports", content='{"time": 1, "x": 1, "y": 1}', headers=headers)
    assert done.status_code == 403
    url = f"ws://127.0.0.1:{open_one.port}/stream"
    with pytest.raises(InvalidStatus) as refused, listen(url, additional_headers=headers):
        pass
    assert refused.value.response.status_code == 403


def test_our_own_origin_can_post_and_listen(open_one: Serving) -> None:
    own = {"origin": open_one.url, "sec-fetch-site": "same-origin"}
    line = '{"time": 1, "x": 1, "y": 1}'
    assert post(f"{open_one.url}/reports", content=line, headers=own).is_success
    with listen(f"ws://127.0.0.1:{open_one.port}/stream", origin=open_one.url) as stream:
        assert '"full":true' in stream.recv()


def test_origins_that_are_told_are_ours_too() -> None:
    settings = WebSettings(origins=("https://tracks.example.org",))
    with Serving(RememberingDesk(), settings) as running:
        headers = {"origin": "https://tracks.example.org", "host": "tracks.example.org"}
        done = post(f"{running.url}/reports", content=b"", headers=headers)
        assert done.status_code == 200


def test_listening_needs_the_token_or_the_pages_login(locked: Serving) -> None:
    url = f"ws://127.0.0.1:{locked.port}/stream"
    for headers in ({}, bearer("wrong"), {"cookie": "trackweave=abc"}):
        with pytest.raises(InvalidStatus) as refused, listen(url, additional_headers=headers):
            pass
        assert refused.value.response.status_code == 401
    with listen(url, additional_headers=bearer()) as stream:
        assert '"full":true' in stream.recv()
    done = post(f"{locked.url}/login", data={"token": TOKEN})
    cookie = done.headers["set-cookie"].partition(";")[0]
    with listen(url, additional_headers={"cookie": cookie}) as stream:
        assert '"full":true' in stream.recv()


@pytest.mark.parametrize(
    "path",
    [
        "/../../../../etc/passwd",
        "/..%2f..%2f..%2fetc%2fpasswd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "//etc/passwd",
        "/tracks/..%2f..%2fetc%2fpasswd",
        "/tracks/%00",
        "/main.js%00.png",
        "/C:%5cwindows",
        "/__init__.py",
        "/%ff%fe",
    ],
)
def test_no_path_reaches_the_file_system(open_one: Serving, path: str) -> None:
    head = f"GET {path} HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n"
    found = open_one.talk(head.encode())
    assert found.split()[1] == b"404"
    assert b"root:" not in found


def test_nothing_that_is_told_becomes_a_header_of_ours(open_one: Serving) -> None:
    for path in ("/x%0d%0aset-cookie:%20a=b", "/tracks?format=x%0d%0aset-cookie:%20a=b"):
        head = f"GET {path} HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n"
        found = open_one.talk(head.encode())
        assert b"set-cookie" not in found.partition(b"\r\n\r\n")[0].lower()
