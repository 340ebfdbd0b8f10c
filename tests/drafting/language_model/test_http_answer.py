"""One request to a real server: what it answers comes back as it is, within the time and the size."""

import time
from email.message import Message
from email.utils import formatdate

import pytest

from lidardraft.drafting.language_model.http_answer import MAX_BYTES, HttpAnswer, TimeLimit, post
from lidardraft.errors import LanguageModelError
from replay_server import Answer, Drip, ReplayServer


def test_an_answer_has_status_headers_and_body(server: ReplayServer) -> None:
    server.answers = [Answer({"a": 1}), Answer(b"busy", 429, (("Retry-After", "7"),))]
    good = post(server.url, {"X-Name": "value"}, b'{"b": 2}', TimeLimit(60))
    assert (good.status, good.body) == (200, b'{"a": 1}')
    busy = post(server.url, {}, b"{}", TimeLimit(60))
    assert (busy.status, busy.body, busy.retry_after()) == (429, b"busy", 7.0)
    (first, _) = server.requests
    assert (first.path, first.headers["x-name"], first.body) == ("/v1", "value", {"b": 2})


@pytest.mark.parametrize("status", [301, 302, 303, 307, 308])
def test_no_redirection_is_followed(server: ReplayServer, status: int) -> None:
    server.answers = [Answer(b"", status, (("Location", f"http://{server.host}/elsewhere"),)), Answer({"a": 1})]
    assert post(server.url, {}, b"{}", TimeLimit(60)).status == status
    assert len(server.requests) == 1


@pytest.mark.parametrize(
    "drip",
    [
        Drip(),
        Drip(b"HTTP/1.1 200 OK\r\n", b"X"),
        Drip(b"HTTP/1.1 200 OK\r\nContent-Length: 1000000\r\n\r\n", b" "),
        Drip(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n", b"1\r\n \r\n"),
    ],
    ids=["nothing", "headers", "body", "chunks"],
)
def test_a_server_that_takes_for_ever_gets_no_more_than_the_limit(server: ReplayServer, drip: Drip) -> None:
    server.answers = [drip]
    with pytest.raises(TimeoutError):
        post(server.url, {}, b"{}", TimeLimit(0.5))


@pytest.mark.parametrize("size", [MAX_BYTES - 1, MAX_BYTES, MAX_BYTES + 1, 3 * MAX_BYTES])
def test_no_more_is_read_than_an_answer_may_have(server: ReplayServer, size: int) -> None:
    server.answers = [Answer(b" " * size)]
    assert len(post(server.url, {}, b"{}", TimeLimit(60)).body) == min(size, MAX_BYTES + 1)


def test_no_answer_is_an_error_of_the_system(server: ReplayServer) -> None:
    server.answers = [Answer(b"", 200, (("X", "y" * 70_000),))]
    with pytest.raises(OSError, match="LineTooLong"):
        post(server.url, {}, b"{}", TimeLimit(60))
    server.__exit__()
    with pytest.raises(OSError, match="refused"):
        post(server.url, {}, b"{}", TimeLimit(60))
    for url in (f"https://{'a' * 70}.example/v1", "http://a..b/v1", "http://a b/v1"):
        with pytest.raises(OSError, match=r"\w"):
            post(url, {}, b"{}", TimeLimit(60))


def test_proxies_of_the_environment_are_used(server: ReplayServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("http_proxy", f"http://{server.host}")
    server.answers = [Answer({"a": 1})]
    assert post("http://model.invalid/v1", {}, b"{}", TimeLimit(60)).status == 200
    assert server.requests[0].path == "http://model.invalid/v1"


@pytest.mark.parametrize(
    ("said", "wait"),
    [("0", 0), ("30", 30), ("", None), ("soon", None), ("-5", None), ("9" * 400, None), (formatdate(0), 0)],
)
def test_how_long_a_server_asks_to_wait(said: str, wait: float | None) -> None:
    headers = Message()
    headers["Retry-After"] = said
    assert HttpAnswer(429, headers, b"").retry_after() == wait


def test_a_date_to_wait_for_is_so_many_seconds_away() -> None:
    headers = Message()
    headers["Retry-After"] = formatdate(time.time() + 1000, usegmt=True)
    wait = HttpAnswer(429, headers, b"").retry_after()
    assert wait is not None
    assert 900 < wait <= 1000


@pytest.mark.parametrize("seconds", [1e7, 0, -1, float("nan"), float("inf"), "5", None, True])
def test_a_limit_is_a_number_of_seconds(seconds: float) -> None:
    with pytest.raises(LanguageModelError, match="it must be a number of seconds over 0"):
        TimeLimit(seconds)
