"""Links that follow a script, so that a test reads as the transcript of a conversation."""

import queue
from zlib import crc32


def sealed(body: str) -> bytes:
    """A line as the other end would send it; the checksum is made here, not by the program."""
    return f"{body}*{crc32(body.encode()):08X}".encode()


NOISE = b"\x00\xff~~ noise"


class _Script:
    """What is written is held to a script; what it answers is read line by line."""

    def __init__(self, *exchanges):
        self.script = list(exchanges)
        self.inbox = []
        self.closed = False

    def read_line(self, timeout_s):
        assert timeout_s >= 0.0
        return self.inbox.pop(0) if self.inbox else None

    def close(self):
        self.closed = True

    def assert_finished(self):
        assert not self.script, f"never asked: {self.script}"
        assert not self.inbox, f"never read: {self.inbox}"


class ScriptedLines(_Script):
    """Expects exactly these lines and answers each with these; no lines are silence."""

    def write(self, data):
        assert data.endswith(b"\n")
        assert data.count(b"\n") == 1
        assert self.script, f"unexpected request {data!r}"
        expected, *lines = self.script.pop(0)
        assert data == expected.encode() + b"\n"
        self.inbox += [line if isinstance(line, bytes) else line.encode() for line in lines]


class ScriptedLink(_Script):
    """Expects exactly the scripted requests and answers each with its scripted replies.

    An exchange is ``(request, reply, ...)`` without ``>``, ``<`` and checksum; a reply may also be
    raw bytes. ``?`` stands for the nonce of OPEN. No reply is silence, and takes no time.
    """

    nonce = None

    def write(self, data):
        assert data.endswith(b"\r\n")
        line = data[:-2]
        body = line[:-9].decode()
        assert line == sealed(body), f"bad checksum: {line!r}"
        assert self.script, f"unexpected request {body!r}"
        expected, *replies = self.script.pop(0)
        if expected.endswith(" OPEN ?"):
            self.nonce = body[-8:]
            assert int(self.nonce, 16) >= 0
        assert body == ">" + expected.replace("?", self.nonce or "?")
        for reply in replies:
            if isinstance(reply, str):
                reply = sealed("<" + reply.replace("?", self.nonce or "?"))
            self.inbox.append(reply)


OPENING = (
    ("0001 OPEN ?", "0001 OK ?"),
    ("0002 ID", "0002 OK SOLARTRAK-EMU 0007 1.0 1 X"),
)
SITE = "OK 35.05000 -106.48000 1830.0 7.00 azel 0.00000"


class HandFedLink:
    """The test sees every line written and hands over every line read, one at a time."""

    def __init__(self):
        self.sent = queue.Queue()
        self.replies = queue.Queue()

    def write(self, data):
        self.sent.put(data[: data.index(b"*")].decode())

    def read_line(self, timeout_s):
        return self.replies.get(timeout=10)

    def close(self):
        pass

    def next_sent(self):
        return self.sent.get(timeout=10)

    def answer(self, body):
        self.replies.put(sealed("<" + body))

    def be_silent(self):
        self.replies.put(None)
