"""The class of the how-to guide is a drive."""

import re
import sys
from pathlib import Path
from types import ModuleType

from bdt_driver.guarded_drive import GuardedDrive

PAGE = Path(__file__).parents[2] / "docs" / "source" / "how-to" / "use-your-own-hardware.md"


SAID = []


class Device:
    """An amplifier, and a sensor that reads micrometers."""

    def __init__(self, port):
        SAID.append(port)

    def position(self):
        return 1500.0

    def set(self, voltage):
        SAID.append(voltage)

    def off(self):
        SAID.append("off")

    def close(self):
        SAID.append("closed")


def test_it_drives(tmp_path, monkeypatch):
    page = PAGE.read_text(encoding="utf-8")
    (code,) = re.findall(r":caption: my_drive\.py\n(.*?)```", page, re.DOTALL)
    (tmp_path / "my_drive.py").write_text(code, encoding="utf-8")
    hardware = ModuleType("my_hardware")
    hardware.Amplifier = hardware.Sensor = Device
    monkeypatch.setitem(sys.modules, "my_hardware", hardware)
    monkeypatch.chdir(tmp_path)
    SAID.clear()
    drive = GuardedDrive("my_drive:MyDrive", {"port": "/dev/x"}, 1.0, lambda line: None)
    drive.close()
    drive.open()
    assert drive.read()[:3] == (1.5e-3, 0.0, None)
    drive.write(3.0)
    assert drive.read()[:3] == (1.5e-3, 3.0, None)
    drive.stop()
    assert drive.read()[:3] == (1.5e-3, 0.0, None)
    drive.close()
    drive.end()
    assert SAID == ["/dev/x", "/dev/x", "off", 3.0, "off", "closed"]
    monkeypatch.delitem(sys.modules, "my_drive")
