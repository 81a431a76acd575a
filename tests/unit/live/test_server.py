"""The server of the live page: who is let in, what a stranger gets, and how it bears many pages and nonsense."""

import contextlib
import functools
import http.client
import json
import random
import signal
import subprocess
import sys
import time
import types
from urllib.parse import urlsplit

import psutil
import pytest
import uvicorn
from websockets.exceptions import ConnectionClosed, InvalidStatus

import swarmcensus as sc
from swarmcensus.live import server
from swarmcensus.live.choices import offer_of
from swarmcensus.live.server import listen, serving
from swarmcensus.live.sessions import Session
from swarmcensus.support.errors import InputError
from tests.support.long import in_two_sizes
from tests.support.watching import ask, talk

# uvicorn itself still asks websockets for a part that is going out of use
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


@pytest.fixture(scope="module")
def served():
    made = listen(offer_of(None))
    with serving(made):
        yield made


def get(served, path, host=None, method="GET"):
    with contextlib.closing(http.client.HTTPConnection("127.0.0.1", served.port, timeout=10)) as connection:
        connection.request(method, path, headers={"Host": host or f"127.0.0.1:{served.port}"})
        with connection.getresponse() as answer:
            return answer.status, answer.read(), {name.lower(): value for name, value in answer.getheaders()}


def frames(page, first, last):
    """Frames one by one: of several at a time, as many are answered as are there soon."""
    one = {"do": "frames", "step": 1, "count": 1}
    return [ask(page, id=tick, **one | {"from": tick})[0] for tick in range(first, last + 1)]


def test_the_page_and_its_parts_are_there(served):
    status, page, headers = get(served, f"/?token={served.token}")
    assert status == 200
    assert b"<title>swarmcensus watch</title>" in page
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    for line in page.decode().splitlines():
        for mark in ('src="', 'stylesheet" href="'):
            if mark in line:
                name = line.split(mark)[1].split('"')[0]
                assert "/" not in name  # nothing is fetched from elsewhere
                assert get(served, f"/{name}")[0] == 200
    assert b"<script>" not in page


@pytest.mark.parametrize("path", ["/", "/?token=", "/?token=x", "/?tok=1", "/?token=%ff", "/?" + "a&" * 30])
def test_without_the_token_there_is_nothing_to_see(served, path):
    status, page, _ = get(served, path)
    assert status in (400, 403)
    assert b"<html" not in page


def test_a_trial_is_saved_as_a_page_by_who_has_the_token(served):
    asked = "topology=ring&robots=5&rounds=10&colour=belief"
    status, page, _ = get(served, f"/run.html?token={served.token}&{asked}")
    assert (status, b'id="recorded"' in page, b'"played": {"colour": "belief"}' in page) == (200, True, True)
    status, told, _ = get(served, f"/run.html?token={served.token}&robots=many")
    assert (status, told) == (422, b'a small swarm: swarm.robots = "many": should be a whole number')
    status, told, _ = get(served, f"/run.html?token={served.token}&{asked}&tick=11")
    assert (status, told) == (422, b"tick = 11: should be a whole number from 0 to 10")
    assert get(served, f"/run.html?token=x&{asked}")[0] == 403
    assert get(served, f"/run.html?token={served.token}", host="evil.example")[0] == 403


@pytest.mark.parametrize("path", ["/server.py", "/..%2fserver.py", "/%2e%2e/offers.py", "/live/x", "//x/"])
@pytest.mark.parametrize("host", [None, "evil.example"])
def test_nothing_else_is_served(served, path, host):
    status, _, headers = get(served, path, host)
    assert status == 404
    assert "default-src 'none'" in headers["content-security-policy"]


@pytest.mark.parametrize(("host", "statuses"), [
    ("evil.example:80", (400, 421)), ("127.0.0.1.evil.example", (400, 421)), ("a@b", (400, 421)), ("[", (400, 421)),
    ("localhost:9000", (200,)), ("[::1]:80", (200,)),
])  # fmt: skip
def test_names_of_this_machine_are_answered_and_no_others(served, host, statuses):
    """A page of another site that had its name point here would come with that name."""
    assert get(served, f"/?token={served.token}", host)[0] in statuses


@pytest.mark.parametrize(
    "wrong", [{"token": "x"}, {"token": ""}, {"origin": "http://evil.example"}, {"origin": None}, {"origin": "null"}]
)
def test_strangers_do_not_talk(served, wrong):
    with pytest.raises(InvalidStatus, match="403"):
        talk(served, **wrong)


def test_pages_are_independent_of_each_other(served):
    with talk(served) as one, talk(served) as other:
        ask(one, id=1, do="begin", ask={"brain": "commons"})
        ask(other, id=1, do="begin", ask={"topology": "ring", "robots": "7"})
        first = frames(one, 5, 7)
        assert len(frames(other, 900, 902)) == 3
        assert frames(one, 5, 7) == first


def test_pages_have_room_and_no_more_come(served, monkeypatch):
    monkeypatch.setattr(server, "MOST_PAGES", 2)
    with talk(served), talk(served), pytest.raises(InvalidStatus, match="403"):
        talk(served)


def test_too_much_at_once_closes_one_page_alone(served):
    with talk(served) as other:
        with contextlib.suppress(ConnectionClosed), talk(served) as page:
            page.send("x" * 1_000_000)
            with pytest.raises(ConnectionClosed):
                page.recv(timeout=10)
        ask(other, id=1, do="begin", ask={})


@pytest.fixture
def hasty(monkeypatch):
    """A server that wants a sign of life of its pages every fifth of a second, in place of 20 seconds."""
    often = functools.partial(uvicorn.Config, ws_ping_interval=0.2, ws_ping_timeout=0.2)
    monkeypatch.setattr(uvicorn, "Config", often)
    made = listen(offer_of(None))
    with serving(made):
        yield made


def test_requests_during_long_computation_are_answered(hasty, monkeypatch):
    begun = Session.answer
    monkeypatch.setattr(Session, "answer", lambda *given: (time.sleep(0.3), begun(*given))[1])
    with talk(hasty) as page:
        for number in range(4):
            page.send(json.dumps({"id": number, "do": "begin", "ask": {"trial": str(number)}}))
        assert [json.loads(page.recv(timeout=60))["id"] for _ in range(4)] == [0, 1, 2, 3]


def test_an_answer_that_cannot_be_written_ends_no_connection(served, monkeypatch):
    monkeypatch.setattr(Session, "_frames", lambda *_: [{"share": float("nan")}])
    with talk(served) as page:
        assert "internal error: ValueError" in ask(page, id=1, do="frames")[1]["error"]
        _, said = ask(page, id=2, do="begin", ask={"brain": "none"})
        assert "this brain's source is not stored here" in said["error"]


def test_a_page_that_goes_stops_its_computing(served):
    me = psutil.Process()
    page = talk(served)
    ask(page, id=1, do="begin", ask={"robots": "1500", "density": "1"})
    page.send(json.dumps({"id": 2, "do": "frames", "from": 10_000, "step": 1, "count": 1}))
    time.sleep(0.1)
    page.close()
    time.sleep(0.5)
    before = sum(me.cpu_times()[:2])
    time.sleep(0.5)
    assert sum(me.cpu_times()[:2]) - before < 0.25


@in_two_sizes(("requests", "pages"), (300, 50), (1000, 200))
def test_random_bytes_on_every_route(served, requests, pages):
    chance = random.Random(1)
    for _ in range(requests):
        connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=10)
        connection.connect()
        method = chance.choice([b"GET ", b"POST ", b"PUT ", b"", b"\x16\x03\x01"])
        path = chance.choice([b"/", b"/live", b"/?token=", b"/main.js", b""]) + chance.randbytes(chance.randrange(12))
        more = chance.choice([b"Host: localhost\r\n", b"", b"Upgrade: websocket\r\nConnection: upgrade\r\n"])
        head = chance.choice([b" HTTP/1.1\r\n", b"\r\n"]) + more + b"\r\n"
        with contextlib.suppress(OSError):
            connection.sock.sendall(method + path + head + chance.randbytes(chance.randrange(50)))
            connection.sock.shutdown(1)
            connection.sock.settimeout(5)
            while connection.sock.recv(4096):
                pass
        connection.close()
    for _ in range(pages):
        with contextlib.suppress(ConnectionClosed, InvalidStatus), talk(served) as page:
            for _ in range(10):
                said = chance.randbytes(chance.randrange(200))
                page.send(said if chance.random() < 0.5 else said.decode("latin-1"))
                assert "error" in json.loads(page.recv(timeout=10))
    assert get(served, f"/?token={served.token}")[0] == 200


def test_a_port_in_use_is_reported(served):
    with pytest.raises(InputError, match=f"cannot listen on 127.0.0.1, port {served.port}: Address already in use"):
        listen(served.offer, port=served.port)


def test_it_listens_on_loopback_alone(served):
    assert served.host == "127.0.0.1"
    others = [a.address for some in psutil.net_if_addrs().values() for a in some if a.family.name == "AF_INET"]
    for address in (a for a in others if not a.startswith("127.")):
        with pytest.raises(OSError, match=r"refused|unreachable|timed out"):
            http.client.HTTPConnection(address, served.port, timeout=2).connect()


@pytest.mark.parametrize(("given", "said"), [
    ("--view besid=voter", "--view besid: did you mean 'beside'?"),
    ("--set tick=0", "world.body.tick = 0: should be greater than 0"),
    ("--moment #robots=-4", "robots = -4"),
    ("--moment nolink", "--moment nolink: should be a copied link, or the part of it behind #"),
    ("--view tick=10001", "tick = 10001"),
    ("--view colour=red", "colour = red"),
    ("mine.py", "there is no such file"),
    ("--out run.txt", "--out run.txt"),
    ("--host 256.1.1.1", "cannot listen on 256.1.1.1, port 0"),
    ("--out folder/none/run.html --set robots=99999", "robots = 99999: at most 20,000 robots can be watched"),
])  # fmt: skip
def test_mistakes_are_refused_in_a_sentence(given, said, refused):
    assert said in refused("watch", "--no-browser", *given.split())


def test_the_command_prints_the_address_and_serves(monkeypatch, accepted):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("swarmcensus.live.serve", lambda served: (time.sleep(0.5), served.socket.close()))
    address = accepted("watch", "--view", "tick=70", "--set", "robots=9", "--set", "side=3").out.strip()
    assert address.startswith("http://127.0.0.1:")
    assert address.endswith("#robots=9&world.side=3&tick=70")
    assert opened == [address]


@pytest.mark.long(only=["1"])
@pytest.mark.parametrize("times", [1, 3])
def test_ctrl_c_ends_it_at_once_whatever_is_computed(times):
    code = """if True:
        import threading, time
        from swarmcensus.cli import program
        from swarmcensus.live import server
        from swarmcensus.live.sessions import Session
        Session.answer = lambda *_: (print("begun", flush=True), [sum(range(10**4)) for _ in range(10**6)])
        server.warm = lambda *_: None
        program.program()
    """
    words = [sys.executable, "-c", code, "watch", "--no-browser"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        try:
            address = urlsplit(running.stdout.readline().strip())
            to = types.SimpleNamespace(port=address.port, token=address.query.removeprefix("token="))
            with talk(to) as page:
                page.send("{}")
                assert running.stdout.readline() == "begun\n"
                began = time.monotonic()
                for _ in range(times):
                    running.send_signal(signal.SIGINT)
                    time.sleep(0.05)
                assert running.wait(10) == 0
                assert time.monotonic() - began < 5
            assert running.stderr.read() == "Press Ctrl-C to stop.\n"
        finally:
            running.kill()


def test_from_python_it_is_a_frame():
    for options, said in (
        ({"robots": "many"}, 'robots = "many"'),
        ({"port": "x"}, "port='x': should be a whole number from 0 to 65,535"),
        ({"height": True}, "height=True: should be"),
        ({"robot": 500}, "robot = 500"),
    ):
        with pytest.raises(InputError, match=said):
            sc.watch(**options)
    study = sc.Study(trials=2, swarm={"robots": 5, "accuracy": 0.7}, world={"topology": "ring", "fill_ratio": 0.5})
    shown = sc.watch(study, trial=1, tick=30, beside="commons")
    try:
        assert shown.address.endswith("#trial=1&beside=commons&tick=30")
        port = int(shown.address.split(":")[2].split("/")[0])
        path = shown.address.split(str(port))[1].split("#")[0]
        status, page, _ = get(types.SimpleNamespace(port=port), path)
        assert (status, b"swarmcensus" in page) == (200, True)
        assert 'src="http://127.0.0.1:' in shown._repr_html_()
    finally:
        shown.stop()
    with pytest.raises(OSError, match="refused"):
        http.client.HTTPConnection("127.0.0.1", port, timeout=2).connect()
