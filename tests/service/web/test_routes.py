"""What is asked for and answered, by a real client of a real server."""

import json
from collections.abc import Iterator

import httpx
import pytest

from oracles.serving import RememberingDesk, Serving, get
from trackweave.errors import OutputError
from trackweave.formats.registry import formats
from trackweave.service.board import Board
from trackweave.service.desk import OverloadedError


@pytest.fixture(scope="module")
def serving() -> Iterator[Serving]:
    with Serving(RememberingDesk()) as running:
        yield running


@pytest.fixture
def client(serving: Serving) -> Iterator[httpx.Client]:
    serving.desk.fault, serving.desk.status = None, "ok"
    with httpx.Client(base_url=serving.url, timeout=60) as client:
        yield client


def test_reports_are_acknowledged_with_how_many_and_the_sequence(
    serving: Serving, client: httpx.Client
) -> None:
    lines = "".join(json.dumps({"time": t, "x": 1.0, "y": 2.0}) + "\n" for t in range(3))
    done = client.post("/reports", content=lines)
    assert done.status_code == 200
    assert done.json() == {"accepted": 3, "rejected": [], "sequence": serving.desk.sequence}
    taken = serving.desk.taken[-1]
    assert taken.table["time"].to_list() == [0.0, 1.0, 2.0]
    assert taken.source == "http 127.0.0.1"


def test_each_rejected_report_is_named_by_its_line(client: httpx.Client) -> None:
    lines = '{"time": 1, "x": 1, "y": 1}\n\nnonsense\n{"time": 2, "x": null, "y": 1, "lat": 3}\n'
    found = client.post("/reports", content=lines + '{"a": 1}\n{"time": 3, "x": 2, "y": 2}').json()
    assert found["accepted"] == 2
    assert [each["row"] for each in found["rejected"]] == [3, 4, 5]


@pytest.mark.parametrize(
    ("content", "headers", "query"),
    [
        (b"time,x,y\n1,2,3\n2,3,4\n", {"content-type": "text/csv"}, ""),
        (b"time,x,y\n1,2,3\n2,3,4\n", {}, ""),
        (b'[{"time":1,"x":2,"y":3},{"time":2,"x":3,"y":4}]', {}, ""),
        (b"1,-1,10,20,30,40,1,-1,-1,-1\n2,-1,10,20,30,40,1,-1,-1,-1\n", {}, "?format=mot"),
        (b"1,-1,1,2,3,4,1,-1,-1,-1\n2,-1,1,2,3,4,1,-1,-1,-1\n", {}, "?format=mot&frame_rate=5"),
        (
            b'{"time":1,"x":2,"y":3}\n{"time":2,"x":3,"y":4}',
            {"content-type": "application/x-www-form-urlencoded"},
            "",
        ),
    ],
)
def test_any_format_that_is_named_or_found_is_taken(
    client: httpx.Client, content: bytes, headers: dict[str, str], query: str
) -> None:
    done = client.post(f"/reports{query}", content=content, headers=headers)
    assert done.json()["accepted"] == 2, done.text


@pytest.mark.parametrize(
    ("content", "headers", "query", "status", "said"),
    [
        (b"\x00\x01\x02\x03", {}, "", 400, "of no format that is known"),
        (b"{}", {}, "?format=nonsense", 400, "expected one that can be read"),
        (b"{}", {}, "?frame_rate=3", 400, "expected format="),
        (b"{}", {}, "?format=mot&frame_rate=-3", 400, "expected a number > 0"),
        (b"PAR1" + bytes(64) + b"PAR1", {}, "?format=parquet", 400, "damaged Parquet data"),
        (b"{}", {"content-encoding": "gzip"}, "", 415, "packed"),
    ],
)
def test_what_cannot_be_reports_is_refused_with_the_reason(
    client: httpx.Client,
    content: bytes,
    headers: dict[str, str],
    query: str,
    status: int,
    said: str,
) -> None:
    done = client.post(f"/reports{query}", content=content, headers=headers)
    assert done.status_code == status
    assert said in done.json()["error"]


def test_nothing_is_acknowledged_that_the_disk_refuses(
    serving: Serving, client: httpx.Client
) -> None:
    for fault in (OutputError("journal: no space left"), OverloadedError("too much at once")):
        serving.desk.fault = fault
        done = client.post("/reports", content='{"time": 1, "x": 1, "y": 1}')
        assert done.status_code == 503
        assert str(fault) in done.json()["error"]
        assert done.headers["retry-after"] == "1"


def test_a_fault_of_ours_shows_nothing_of_itself(serving: Serving, client: httpx.Client) -> None:
    serving.desk.fault = RuntimeError("the secret inside")
    done = client.post("/reports", content='{"time": 1, "x": 1, "y": 1}')
    assert done.status_code == 500
    assert "secret" not in done.text


def test_an_empty_body_is_no_report(serving: Serving, client: httpx.Client) -> None:
    found = client.post("/reports", content=b" \n").json()
    assert found == {"accepted": 0, "rejected": [], "sequence": serving.desk.sequence}


def test_tracks_are_geojson_unless_told_otherwise(client: httpx.Client) -> None:
    done = client.get("/tracks")
    assert done.headers["content-type"] == "application/geo+json"
    features = done.json()["features"]
    assert [each["id"] for each in features] == [1, 2, 4, 5]  # what is not tentative
    assert all(abs(each["geometry"]["coordinates"][1] - 48) < 1 for each in features)


@pytest.mark.parametrize("name", sorted(n for n, f in formats().items() if f.writer))
def test_tracks_come_in_every_format_that_can_say_them(client: httpx.Client, name: str) -> None:
    done = client.get("/tracks", params={"format": name})
    if done.status_code == 400:  # boxes and pixels of a video are not known of aircraft
        assert "expected" in done.json()["error"]
        assert name in {"mot", "kitti", "coco", "ctc", "geff"}
    else:
        assert done.status_code == 200
        assert len(done.content) > 100


def test_a_format_that_cannot_be_written_is_refused(client: httpx.Client) -> None:
    done = client.get("/tracks", params={"format": "../../etc/passwd"})
    assert done.status_code == 400
    assert "expected one that can be written" in done.json()["error"]


def test_tracks_of_a_plane_say_that_they_are_on_none_of_the_earths_places() -> None:
    with Serving(RememberingDesk(is_on_earth=False)) as running:
        found = get(f"{running.url}/tracks").json()
        refused = get(f"{running.url}/tracks", params={"format": "kml"})
    assert found["crs"]["properties"]["name"].startswith("ENGCRS[")
    assert len(found["features"]) == 6
    assert abs(found["features"][0]["geometry"]["coordinates"][0]) > 90
    assert refused.status_code == 400
    assert "lat,lon" in refused.json()["error"]


def test_no_tracks_are_an_empty_picture_in_every_format() -> None:
    desk = RememberingDesk(0)
    with Serving(desk) as running:
        assert get(f"{running.url}/tracks").json()["features"] == []
        for name in ("kml", "czml", "cot", "csv", "jsonl", "asterix-062"):
            done = get(f"{running.url}/tracks", params={"format": name})
            assert done.status_code == 200, (name, done.text)


def test_before_anything_is_tracked_the_picture_is_empty_in_every_format() -> None:
    desk = RememberingDesk(0)
    desk.shown = Board().picture
    with Serving(desk) as running:
        assert get(f"{running.url}/tracks").json()["features"] == []
        for name in ("kml", "czml", "cot", "csv", "jsonl", "asterix-062"):
            done = get(f"{running.url}/tracks", params={"format": name})
            assert done.status_code == 200, (name, done.text)


def test_one_track_has_its_trail_and_others_are_not_there(client: httpx.Client) -> None:
    assert client.get("/tracks/1").json()["trail"] == [[0.0, 1.0, 2.0]]
    assert client.get("/tracks/2").status_code == 404
    assert client.get("/tracks/" + "1" * 1000).status_code == 404


def test_health_fails_where_nothing_can_be_taken(serving: Serving, client: httpx.Client) -> None:
    assert client.get("/healthz").status_code == 200
    serving.desk.status = "waiting"
    assert client.get("/healthz").status_code == 200
    serving.desk.status = "failing"
    assert client.get("/healthz").status_code == 503


def test_health_fails_while_what_is_sent_would_be_lost() -> None:
    desk = RememberingDesk()
    desk.status = "starting"
    with Serving(desk) as running:
        assert get(f"{running.url}/healthz").status_code == 200
        desk.is_listening = False
        assert get(f"{running.url}/healthz").status_code == 503


def test_sensors_are_a_list(client: httpx.Client) -> None:
    assert client.get("/sensors").json()[0]["name"] == "radar"


def test_the_page_is_served_with_what_it_may_do(client: httpx.Client) -> None:
    done = client.get("/")
    assert done.text.startswith("<!doctype html>")
    policy = done.headers["content-security-policy"]
    assert "default-src 'none'; script-src 'self'; style-src 'self';" in policy
    assert "unsafe" not in policy
    assert done.headers["x-content-type-options"] == "nosniff"
    assert client.get("/main.js").headers["content-type"].startswith("text/javascript")
    again = client.get("/main.js", headers={"if-none-match": '"2"'})
    assert (again.status_code, again.content) == (304, b"")
    assert client.get("/page.json").json()["login"] is False


def test_other_ways_and_places_are_not_there(client: httpx.Client) -> None:
    assert client.get("/reports").status_code == 405
    assert client.get("/logout").headers["allow"] == "POST"
    assert client.put("/tracks").status_code == 405
    assert client.delete("/tracks/1").status_code == 405
    assert client.get("/nowhere").status_code == 404
