"""Prometheus' text format, by a grammar of our own and by its own client."""

import math
import re
from importlib.util import find_spec

import pytest

from oracles.serving import RememberingDesk, Serving, get
from trackweave.service.web.metrics import CONTENT_TYPE, exposition, of_sensors

NAME = r"[a-zA-Z_:][a-zA-Z0-9_:]*"
LABEL = r'[a-zA-Z_][a-zA-Z0-9_]*="(?:[^"\\\n]|\\["\\n])*"'
VALUE = r"(?:[+-]?Inf|NaN|[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?)"
LINE = re.compile(
    rf"# TYPE {NAME} (?:counter|gauge)|({NAME})(?:\{{{LABEL}(?:,{LABEL})*\}})? {VALUE}"
)
NASTY = ['a"b', "back\\slash", "new\nline", "\x00\x1b[2J", "\u2028", "\ud800", "x" * 1000, "ü"]


def check(text: str) -> None:
    """Check lines, and that those of one metric stand together under its kind, once each."""
    assert text.endswith("\n")
    seen, kinds, kind = set(), set(), ""
    for line in text[:-1].split("\n"):
        found = LINE.fullmatch(line)
        assert found, line
        if line.startswith("#"):
            kind = line.split()[2]
            assert kind not in kinds
            kinds.add(kind)
        else:
            assert found[1] == kind
            assert line.rpartition(" ")[0] not in seen
            seen.add(line.rpartition(" ")[0])


def test_what_is_served_is_prometheus_text() -> None:
    desk = RememberingDesk()
    desk.names = NASTY
    with Serving(desk) as running:
        for path in ("/tracks", "/nowhere"):
            get(f"{running.url}{path}")
        done = get(f"{running.url}/metrics")
    assert done.headers["content-type"] == CONTENT_TYPE
    check(done.text)
    assert "trackweave_reports_total 3\n" in done.text
    assert 'trackweave_http_requests_total{method="GET",status="404"} 1\n' in done.text
    assert "bad name" not in done.text


def test_every_value_and_label_can_be_read() -> None:
    values = (0.0, -1.5, 1e300, 5e-324, math.inf, -math.inf, math.nan, 2**63)
    samples = [(f"number_{k}", {"why": name}, v) for k, v in enumerate(values) for name in NASTY]
    check(exposition([*samples, ("x", {}, 1), ("x", {}, 2), ("bad{", {}, 1)]))
    check(exposition(of_sensors([{"name": n, "last_heard": 3.5, "silent": True} for n in NASTY])))


@pytest.mark.skipif(find_spec("prometheus_client") is None, reason="needs prometheus-client")
def test_its_own_client_reads_the_same_numbers() -> None:
    from prometheus_client.parser import text_string_to_metric_families

    text = exposition([("a_total", {"s": 'q"\\'}, 3), ("b", {}, 0.25), ("c", {}, math.inf)])
    found = {s.name: s for f in text_string_to_metric_families(text) for s in f.samples}
    assert found["trackweave_a_total"].labels == {"s": 'q"\\'}
    assert [found[f"trackweave_{n}"].value for n in ("a_total", "b", "c")] == [3, 0.25, math.inf]
