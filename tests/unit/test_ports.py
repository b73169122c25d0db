"""What ``solarcal ports`` says of what is plugged in."""

import argparse
import json
import os
from types import SimpleNamespace

import pytest

from solarcal.cli import readiness


def plugged_in(device, description="n/a", vid=None, pid=None, product=None):
    return SimpleNamespace(
        device=str(device),
        description=description,
        manufacturer=None,
        serial_number=None,
        product=product,
        vid=vid,
        pid=pid,
    )


@pytest.mark.parametrize(
    ("port", "looks_like", "likely"),
    [
        (plugged_in("/dev/ttyUSB0", "FT232R USB UART", 0x0403, 0x6001), "FTDI", True),
        (plugged_in("/dev/ttyUSB1", "USB Serial", 0x1A86, 0x7523), "CH340", True),
        (plugged_in("/dev/ttyACM0", "u-blox GNSS receiver", 0x1546, 0x01A7), "GPS", False),
        (plugged_in("/dev/ttyUSB2", "GPS on FTDI", 0x0403, 0x6001), "GPS", False),
        (plugged_in("/dev/ttyACM1", "ttyACM1", 0x2341, 0x0043), "Arduino", False),
        (plugged_in("COM7", "Standard Serial over Bluetooth link (COM7)"), "Bluetooth", False),
        (plugged_in("COM3", "Some Serial Port"), "serial adapter", True),
        (plugged_in("/dev/ttyS0"), "built-in", True),
        (plugged_in("/dev/ttyXR9"), "unknown", False),
    ],
)
def test_what_a_port_looks_like(port, looks_like, likely):
    described = readiness.describe(port)
    assert looks_like in described["looks_like"]
    assert described["likely"] is likely


@pytest.mark.parametrize(
    ("vid", "maker", "likely"),
    [
        (0x0403, "FTDI", True),
        (0x10C4, "Silicon Labs", True),
        (0x1A86, "CH340", True),
        (0x067B, "Prolific", True),
        (0x04D8, "Microchip", True),
        (0x0557, "ATEN", True),
        (0x1546, "u-blox", False),
        (0x2341, "Arduino", False),
        (0x1D6B, "USB gadget", False),
        (0x1199, "Sierra", False),
        (0x12D1, "Huawei", False),
        (0x2C7C, "Quectel", False),
    ],
)
def test_makers_by_the_numbers_of_the_usb_register(vid, maker, likely):
    """An adapter may lead to a controller; receivers, modems and gadgets do not."""
    described = readiness.describe(plugged_in("/dev/ttyUSB0", "device", vid, 1))
    assert maker in described["looks_like"]
    assert described["likely"] is likely


def test_access_is_that_of_the_file(tmp_path, monkeypatch):
    device = tmp_path / "ttyUSB0"
    device.touch()
    monkeypatch.setattr("os.access", lambda _path, mode: mode == os.R_OK)
    described = readiness.describe(plugged_in(device))
    assert (described["readable"], described["writable"]) == (True, False)
    text = readiness.ports_text([described])
    assert "read only" in text
    assert "join the group" in text


def test_a_port_that_is_no_file_has_unknown_access():
    described = readiness.describe(plugged_in("COM3"))
    assert described["readable"] is None
    assert "join the group" not in readiness.ports_text([described])


def run(monkeypatch, found, *, as_json):
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: found)
    return readiness.run_ports(argparse.Namespace(json=as_json))


def test_json_is_one_document(monkeypatch, capsys):
    found = [plugged_in("/dev/ttyUSB0", "FT232R", 0x0403, 0x6001), plugged_in("/dev/ttyS0")]
    assert run(monkeypatch, found, as_json=True) == 0
    document = json.loads(capsys.readouterr().out)
    first, second = document["ports"]
    assert first["port"] == "/dev/ttyS0"
    assert first["description"] == ""
    assert second["usb_id"] == "0403:6001"


def test_the_table_puts_likely_ports_first_and_keeps_to_80_columns(monkeypatch, capsys):
    found = [
        plugged_in("/dev/ttyACM0", "u-blox GNSS", 0x1546, 0x01A7),
        plugged_in("/dev/ttyUSB0", "FT232R USB UART", 0x0403, 0x6001),
    ]
    assert run(monkeypatch, found, as_json=False) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].startswith("/dev/ttyUSB0")
    assert lines[2].startswith("/dev/ttyACM0")
    assert max(map(len, lines)) <= 80


def test_nothing_plugged_in_says_what_to_do(monkeypatch, capsys):
    assert run(monkeypatch, [], as_json=False) == 0
    assert "plug the adapter in" in capsys.readouterr().out
    assert run(monkeypatch, [], as_json=True) == 0
    assert json.loads(capsys.readouterr().out) == {"ports": []}
