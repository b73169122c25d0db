"""Links that follow a script of rotctld's extended protocol; and what a rotctld says of itself."""

STATE = (
    "dump_state:",
    "rotctld Protocol Ver: 1",
    "Rotor Model: 603",
    "Minimum Azimuth: 0.000000",
    "Maximum Azimuth: 450.000000",
    "Minimum Elevation: 0.000000",
    "Maximum Elevation: 180.000000",
    "South Zero: 0",
    "rot_type=AzEl",
    "done",
    "RPRT 0",
)
CAPS = (
    "dump_caps:",
    "Caps dump for model:\t603",
    "Model name:\t\tGS-232B",
    "Mfg name:\t\tYaesu",
    "Backend version:\t20220109.0",
    "Rot type:\t\tAz-El",
    "Can Stop:\t\tY",
    "RPRT 0",
)
AT_REST = ("get_pos:", "Azimuth: 180.00", "Elevation: 45.00", "RPRT 0")
OPENING = (
    ("+\\dump_state", *STATE),
    ("+\\dump_caps", *CAPS),
    ("+\\get_pos", *AT_REST),
)


class ScriptedRotctld:
    """Expects exactly these requests and answers each with these lines; no lines are silence."""

    def __init__(self, *exchanges):
        self.script = list(exchanges)
        self.inbox = []
        self.closed = False

    def write(self, data):
        assert data.endswith(b"\n")
        assert data.count(b"\n") == 1
        assert self.script, f"unexpected request {data!r}"
        expected, *lines = self.script.pop(0)
        assert data == expected.encode() + b"\n"
        self.inbox += [line if isinstance(line, bytes) else line.encode() for line in lines]

    def read_line(self, timeout_s):
        assert timeout_s >= 0.0
        return self.inbox.pop(0) if self.inbox else None

    def close(self):
        self.closed = True

    def assert_finished(self):
        assert not self.script, f"never asked: {self.script}"
        assert not self.inbox, f"never read: {self.inbox}"
