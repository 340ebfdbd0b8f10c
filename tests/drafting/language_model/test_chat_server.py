"""What a server of language models can answer, in each dialect: a reply, or one clear line; never the key.

All of it comes from a real server, within the time and the size that an answer may have.
"""

import time
from email.message import Message
from email.utils import formatdate

import pytest

from lidardraft.drafting.language_model.chat_server import MAX_BYTES, ChatServer, HttpAnswer, TimeLimit, post
from lidardraft.errors import LanguageModelError
from replay_server import DIALECTS, Answer, Drip, ReplayServer, openai

MESSAGES = [{"role": "user", "content": "hello"}]
FORMAT = {"response_format": {"type": "json_schema"}}
SECRET = "sk-proj-0123456789/abc=="
AT_ONCE = (("Retry-After", "0"),)


def refused(server: ReplayServer, *answers: Answer | Drip, seconds: float = 60, options: bool = False) -> str:
    """The one line that some answers end in."""
    server.answers = list(answers)
    with pytest.raises(LanguageModelError) as caught:
        ChatServer(server.url, "small").reply(MESSAGES, FORMAT if options else {}, TimeLimit(seconds))
    said = str(caught.value)
    assert said.startswith(f"{server.url}: ")
    assert said.isprintable()
    assert SECRET not in said
    return said.removeprefix(f"{server.url}: ")


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_reply_in_each_dialect(server: ReplayServer, dialect: str) -> None:
    answer = DIALECTS[dialect]("a bus")
    server.answers = [answer]
    reply = ChatServer(f"{server.url}/", "small").reply(MESSAGES, FORMAT, TimeLimit(60))
    assert (reply.text, reply.model, reply.is_cut) == ("a bus", answer.body["model"], False)
    (request,) = server.requests
    assert request.path == "/v1/chat/completions"
    assert request.body == {"model": "small", "messages": MESSAGES, **FORMAT}
    assert request.headers["content-type"] == "application/json"
    assert request.headers["user-agent"] == "lidardraft"
    assert "authorization" not in request.headers


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("text", ["a bu", "", None])
def test_a_reply_that_is_cut_off_in_each_dialect(server: ReplayServer, dialect: str, text: str | None) -> None:
    server.answers = [DIALECTS[dialect](text, finish="length")]
    reply = ChatServer(server.url, "small").reply(MESSAGES, FORMAT, TimeLimit(60))
    assert (reply.text, reply.is_cut) == (text or "", True)


def test_the_key_goes_to_the_server_and_nowhere_else(server: ReplayServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LIDARDRAFT_LLM_KEY", f"{SECRET}\n")
    server.answers = [openai(f"your key is {SECRET}, a bus")]
    chat = ChatServer(server.url, "small")
    assert chat.reply(MESSAGES, {}, TimeLimit(60)).text == "your key is [key], a bus"
    assert server.requests[0].headers["authorization"] == f"Bearer {SECRET}"
    assert SECRET not in repr(chat)
    told = Answer({"error": {"message": f"Incorrect API key provided: {SECRET}."}}, 401)
    assert "401 Unauthorized: Incorrect API key provided: [key].; the key is" in refused(server, told)
    assert "[key]" in refused(server, Answer(SECRET.encode(), 500))
    assert "[key]" in refused(server, Answer(b"", 302, (("Location", f"http://elsewhere/{SECRET}"),)))
    assert "[key]" in refused(server, Answer({"choices": [{"message": {"refusal": SECRET}}]}))


def test_a_key_that_is_a_common_word_is_no_secret(server: ReplayServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LIDARDRAFT_LLM_KEY", "none")
    server.answers = [openai("there are none")]
    assert ChatServer(server.url, "small").reply(MESSAGES, {}, TimeLimit(60)).text == "there are none"


@pytest.mark.parametrize("key", ["sk-one\nX-Header: two", "schlüssel-geheim"])
def test_a_key_that_no_header_holds(server: ReplayServer, monkeypatch: pytest.MonkeyPatch, key: str) -> None:
    monkeypatch.setenv("LIDARDRAFT_LLM_KEY", key)
    with pytest.raises(LanguageModelError, match="the key in LIDARDRAFT_LLM_KEY has characters that no key has") as e:
        ChatServer(server.url, "small").reply(MESSAGES, {}, TimeLimit(60))
    assert key[:6] not in str(e.value)
    assert server.requests == []


@pytest.mark.parametrize(
    "answer",
    [
        Answer({"error": {"code": 400, "message": 'Either "json_schema" or "grammar"', "type": "invalid"}}, 400),
        Answer({"error": {"message": "Invalid schema", "type": "BadRequestError", "param": None, "code": 400}}, 400),
        Answer({"detail": [{"loc": ["body", "response_format"], "msg": "unexpected"}]}, 422),
        Answer({"error": {"message": "grammar failed", "type": "server_error"}}, 500),
        Answer(b"", 501),
    ],
)
def test_a_server_that_refuses_the_response_format_is_asked_without(server: ReplayServer, answer: Answer) -> None:
    server.answers = [answer, openai("a bus")]
    assert ChatServer(server.url, "small").reply(MESSAGES, FORMAT, TimeLimit(60)).text == "a bus"
    assert [sorted(request.body) for request in server.requests] == [
        ["messages", "model", "response_format"],
        ["messages", "model"],
    ]


def test_a_busy_server_is_asked_again_twice(server: ReplayServer) -> None:
    busy = [Answer({"error": {"message": "Rate limit reached"}}, status, AT_ONCE) for status in (429, 503)]
    server.answers = [*busy, openai("a bus")]
    assert ChatServer(server.url, "small").reply(MESSAGES, {}, TimeLimit(60)).text == "a bus"
    assert len(server.requests) == 3
    said = refused(server, *busy, busy[0], openai("too late"))
    assert said == "429 Too Many Requests: Rate limit reached; it can be asked again in 0 s"


def test_a_wait_that_is_longer_than_the_limit_is_told_at_once(server: ReplayServer) -> None:
    answer = Answer({"error": {"message": "quota"}}, 429, (("Retry-After", "86400"),))
    assert refused(server, answer) == "429 Too Many Requests: quota; it can be asked again in 86400 s"
    assert len(server.requests) == 1


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (
            Answer({"error": {"message": "model 'x' not found", "type": "not_found_error"}}, 404),
            "404 Not Found: model 'x' not found; the URL must be that of the API",
        ),
        (Answer({"error": "invalid api key"}, 401), "LIDARDRAFT_LLM_KEY, and it is empty"),
        (Answer({"object": "error", "message": "Forbidden place", "code": 403}, 403), "403 Forbidden: Forbidden place"),
        (Answer(b"<html><h1>Bad\x1b[31m Gateway</h1></html>", 500), "500 Internal Server Error: <html><h1>Bad"),
        (Answer(b"", 599), "599"),
        (
            Answer(b"", 307, (("Location", "https://other.example/v1?token=abc"),)),
            "307 Temporary Redirect: the API is at https://other.example/v1; redirections are not followed",
        ),
        (Answer({"choices": []}), "an answer without a choice"),
        (Answer({"choices": None}), "an answer without a choice"),
        (Answer({"choices": [None]}), "an answer without a choice"),
        (Answer({"choices": [{"finish_reason": "stop"}]}), "an answer without a choice"),
        (Answer({"error": {"message": "Provider returned error"}}), "without a choice: Provider returned error"),
        (Answer(b"<html>", headers=(("Content-Type", "text/html"),)), "an answer (text/html) that is not JSON"),
        (Answer(b'data: {"a": 1}\n\n', headers=(("Content-Type", "text/event-stream"),)), "(text/event-stream)"),
        (Answer(b'{"choices": [{"mess', headers=()), "an answer (of no type) that is not JSON: Unterminated string"),
        (Answer(b"[" * 100_000), "nested too deeply"),
        (Answer([1]), "[1] is not a JSON object"),
        (Answer(b"\xff\xfe\x00"), "that is not JSON"),
        (Answer(b" " * (MAX_BYTES + 1)), f"an answer of more than {MAX_BYTES} bytes"),
        (openai(None, refusal="I'm sorry, I can't assist with that."), "the model refuses: I'm sorry, I can't"),
        (openai(None, finish="content_filter"), "the answer is withheld by a content filter"),
        (openai(None), "an answer without text"),
        (openai(" \n"), "an answer without text"),
        (Answer({"choices": [{"message": {"content": [1], "tool_calls": []}}]}), "an answer without text"),
    ],
)
def test_everything_else_is_one_line(server: ReplayServer, answer: Answer, said: str) -> None:
    assert said in refused(server, answer)


def test_a_server_that_never_answers_is_one_line(server: ReplayServer) -> None:
    assert refused(server, Drip(), seconds=0.4) == "no whole answer within 0.4 s"
    server.__exit__()
    assert refused(server) == "Connection refused"


def test_half_characters_are_replaced(server: ReplayServer) -> None:
    server.answers = [Answer(b'{"model": "\\ud83d", "choices": [{"message": {"content": "a \\ud83d bus"}}]}')]
    reply = ChatServer(server.url, "small").reply(MESSAGES, {}, TimeLimit(60))
    assert reply.text == "a ? bus"


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("", "no language model is named; LIDARDRAFT_LLM_URL or --llm-url is its server"),
        ("localhost:11434/v1", "the URL of the language model is 'localhost:11434/v1'; it must be as http://"),
        ("file:///etc/passwd", "it must be as http://"),
        ("http://", "it must be as http://"),
        ("http:///v1", "it must be as http://"),
        ("http://[::1/v1", "it must be as http://"),
        ("http://host:99999/v1", "it must be as http://"),
        ("http://host/v1 \r\nX: y", "it must be as http://"),
        (f"http://user:{SECRET}@host/v1", "has no user, query or fragment"),
        (f"htp:user:{SECRET}@host/v1", "has no user, query or fragment"),
        (f"http://host/v1?key={SECRET}", "has no user, query or fragment"),
    ],
)
def test_urls_that_no_server_has(url: str, said: str) -> None:
    with pytest.raises(LanguageModelError) as caught:
        ChatServer(url, "small")
    assert said in str(caught.value)
    assert SECRET not in str(caught.value)


def test_a_model_has_a_name() -> None:
    with pytest.raises(LanguageModelError, match="LIDARDRAFT_LLM_MODEL or --llm-model names it"):
        ChatServer("http://localhost:11434/v1", "")


@pytest.mark.parametrize("escaped", [False, True])
def test_no_half_of_a_key_is_left_where_a_message_cuts_it(
    server: ReplayServer, monkeypatch: pytest.MonkeyPatch, escaped: bool
) -> None:
    monkeypatch.setenv("LIDARDRAFT_LLM_KEY", SECRET)
    key = "".join(f"\\u{ord(letter):04x}" for letter in SECRET) if escaped else SECRET
    long = "x" * 290
    for answer in (
        Answer(f'{{"error": "{long}{key}"}}'.encode(), 400),
        Answer(f'{{"choices": [{{"message": {{"refusal": "{long[:280]}{key}"}}}}]}}'.encode()),
    ):
        assert SECRET[:6] not in refused(server, answer)
    if not escaped:
        assert SECRET[:6] not in refused(server, Answer(f"{long}{SECRET}".encode(), 400))
        assert SECRET[:6] not in refused(server, Answer(f"0123456789{SECRET}".encode()))
        assert SECRET[:6] not in refused(server, Answer(b"", 302, (("Location", f"http://{long[:280]}{SECRET}"),)))


def test_a_reply_in_parts(server: ReplayServer) -> None:
    parts = [{"type": "text", "text": "a "}, {"type": "thinking", "text": "no"}, 5, {"type": "text", "text": "bus"}]
    server.answers = [Answer({"choices": [{"message": {"content": parts}, "finish_reason": "stop"}]})]
    assert ChatServer(server.url, "small").reply(MESSAGES, {}, TimeLimit(60)).text == "a bus"


def test_the_whole_url_of_the_chats_is_a_url_too(server: ReplayServer) -> None:
    server.answers = [openai("a bus")]
    assert ChatServer(f"{server.url}/chat/completions/", "small").url == server.url


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


@pytest.mark.parametrize("size", [MAX_BYTES, 3 * MAX_BYTES])
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
    assert asked_to_wait(said) == wait


def test_a_server_may_say_until_when_to_wait() -> None:
    assert asked_to_wait(formatdate(time.time() + 1000, usegmt=True)) == pytest.approx(950, abs=100)


def asked_to_wait(said: str) -> float | None:
    """The seconds of a header."""
    headers = Message()
    headers["Retry-After"] = said
    return HttpAnswer(429, headers, b"").retry_after()


@pytest.mark.parametrize("seconds", [1e7, 0, -1, float("nan"), float("inf"), "5", None, True])
def test_a_limit_is_a_number_of_seconds(seconds: float) -> None:
    with pytest.raises(LanguageModelError, match="it must be a number of seconds over 0"):
        TimeLimit(seconds)
