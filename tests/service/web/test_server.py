"""Listening: with TLS, at addresses that can be had, and an end within a time."""

import asyncio
import socket
import ssl
import subprocess
from pathlib import Path

import httpx
import pytest

from oracles.serving import RememberingDesk, Serving, read_all, until
from trackweave.errors import InvalidInputError, OutputError
from trackweave.service.web.application import application
from trackweave.service.web.server import WebServer, tls_context
from trackweave.service.web.settings import Limits, Tls, WebSettings
from trackweave.service.web.tokens import line_of, read_tokens

TOKEN = "a token of a good length"


@pytest.fixture(scope="module")
def tls(tmp_path_factory: pytest.TempPathFactory) -> Tls:
    folder = tmp_path_factory.mktemp("tls")
    found = Tls(folder / "certificate.pem", folder / "key.pem")
    command = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"]
    command += ["-nodes", "-days", "2", "-subj", "/CN=localhost"]
    command += ["-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1"]
    command += ["-keyout", str(found.key), "-out", str(found.certificate)]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except FileNotFoundError:
        pytest.skip("needs openssl to make a certificate")
    return found


@pytest.fixture
def settings(tmp_path: Path) -> WebSettings:
    file = tmp_path / "tokens"
    file.write_text(line_of(TOKEN))
    limits = Limits(head_s=1.0, connections=20)
    return WebSettings(tokens=read_tokens(file), is_encrypted=True, limits=limits)


def test_tls_is_spoken_and_cookies_never_go_in_clear(tls: Tls, settings: WebSettings) -> None:
    with Serving(RememberingDesk(), settings, "0.0.0.0", tls) as running:
        context = ssl.create_default_context(cafile=str(tls.certificate))
        with httpx.Client(
            base_url=f"https://localhost:{running.port}", verify=context, timeout=60
        ) as client:
            assert client.get("/healthz").status_code == 401
            done = client.post("/login", data={"token": TOKEN})
            assert done.headers["set-cookie"].startswith("__Host-trackweave=")
            assert "secure" in done.headers["set-cookie"].lower()
            assert done.headers["strict-transport-security"]
            assert client.get("/tracks").is_success
            old = ssl.create_default_context(cafile=str(tls.certificate))
            old.maximum_version = ssl.TLSVersion.TLSv1_2
            assert httpx.get(f"{client.base_url}/healthz", verify=old).status_code == 401


def test_whoever_never_greets_is_cut_and_holds_no_place(tls: Tls, settings: WebSettings) -> None:
    with Serving(RememberingDesk(), settings, "127.0.0.1", tls) as running:
        peers = [running.connect() for _ in range(60)]
        assert len(running.server._connections) <= 20
        peers[0].sendall(b"\x16\x03\x01\x02\x00\x01")
        peers[1].sendall(b"GET / HTTP/1.1\r\nhost: localhost\r\n\r\n")  # no TLS at all
        for peer in peers:
            read_all(peer)
            peer.close()
        assert until(lambda: not len(running.server._connections))
        assert running.faults == []


def test_other_machines_are_served_with_token_and_tls_alone(
    tls: Tls, settings: WebSettings, tmp_path: Path
) -> None:
    desk = RememberingDesk()
    for access, with_tls in ((WebSettings(), None), (WebSettings(), tls), (settings, None)):
        with pytest.raises(InvalidInputError, match="reached from other machines"):
            WebServer(application(desk, access), "0.0.0.0", 0, with_tls)
    (tmp_path / "short").write_text("short")
    weak = WebSettings(tokens=read_tokens(tmp_path / "short"))
    with pytest.raises(InvalidInputError, match="--token-file"):
        WebServer(application(desk, weak), "0.0.0.0", 0, tls)
    WebServer(application(desk, settings), "0.0.0.0", 0, tls)


def test_files_that_are_no_certificate_are_refused(tls: Tls, tmp_path: Path) -> None:
    (tmp_path / "nonsense").write_text("nonsense")
    for wrong, said in (
        (Tls(tmp_path / "none", tls.key), "no such file"),
        (Tls(tls.certificate, tmp_path / "nonsense"), "without a password"),
        (Tls(tls.key, tls.certificate), "expected a certificate"),
    ):
        with pytest.raises(InvalidInputError, match=said):
            tls_context(wrong)


def test_an_address_that_is_taken_or_none_is_refused() -> None:
    async def start(host: str, port: int) -> None:
        found = application(RememberingDesk(), WebSettings())
        try:
            await WebServer(found, host, port).start()
        finally:
            found.close()

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(OutputError, match="in use"):
            asyncio.run(start("127.0.0.1", taken.getsockname()[1]))


def test_the_address_says_where_the_page_is() -> None:
    with Serving(RememberingDesk(), host="localhost") as running:
        assert running.server.url == f"http://localhost:{running.port}/"
        assert httpx.get(running.server.url, timeout=60).is_success
