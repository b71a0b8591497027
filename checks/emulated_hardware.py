"""What `make hardware` does: the emulator, all checks of its drive, and a loop on it in real time.

Run as ``python -m checks.emulated_hardware [--duration S]``. It ends what it has started, and with
0 when all was well.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import Any

BDT = (sys.executable, "-m", "bdt_bringup.program")
CONFIGURATION = Path("config/serial_drive.yaml")
PORT_IN_CONFIGURATION = "/dev/ttyUSB0"
TIMEOUT_IN_CONFIGURATION = ": 0.1 "
PATIENCE = ": 1.0 "
"""A device has a clock of its own; this one waits whenever the computer is busy."""
DRIVE = "bdt_drive_emulator.emulated_drive:EmulatedDrive"
CHECKED = (
    "sampling_rate:=5000.0",
    "limits.voltage:=4.0",
    "limits.lowest_position:=-0.005",
    "limits.highest_position:=0.005",
)
CLOCK_ERROR = 0.001
"""The clock of a device is never quite right."""
END_TIMEOUT = 30.0


def main() -> None:
    """Run emulator, checks and loop, and exit with 1 if anything was not well."""
    parser = argparse.ArgumentParser(prog="python -m checks.emulated_hardware")
    parser.add_argument("--duration", type=float, default=60.0, help="of the loop [s]")
    duration = parser.parse_args().duration
    with tempfile.TemporaryDirectory() as folder:
        port = Path(folder) / "port"
        machine = Path(folder) / "serial_drive.yaml"
        text = CONFIGURATION.read_text(encoding="utf-8")
        text = text.replace(PORT_IN_CONFIGURATION, str(port))
        text = text.replace(TIMEOUT_IN_CONFIGURATION, PATIENCE)
        machine.write_text(text, encoding="utf-8")
        begun = datetime.now().astimezone().strftime("%Y%m%d-%H%M%S")
        output = Path("runs") / f"{begun}-hardware"
        try:
            with emulator(port):
                is_checked = not _bdt("hardware-check", DRIVE, *_parameters(port), "--yes")
                runs = not _bdt(
                    *("run", "--config", machine, "--duration", duration, "--output", output)
                )
        except KeyboardInterrupt:
            sys.exit(130)
    faults = [] if is_checked else ["a check has failed"]
    faults += run_faults(output, duration) if runs else ["the loop has failed"]
    print(f"hardware: {'; '.join(faults) or 'all is well'}")
    sys.exit(bool(faults))


@contextmanager
def emulator(port: Path) -> Iterator[None]:
    """Run an emulator with a link to its port.

    Raises
    ------
    RuntimeError
        If it ends before it has a port.
    """
    command = [*BDT, "drive-emulator", "--link", str(port), "--clock-error", str(CLOCK_ERROR)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)  # noqa: S603
    try:
        said = process.stdout.readline() if process.stdout else ""
        if not said:
            raise RuntimeError(f"the emulator has ended with {process.wait()}")
        print(said, end="", flush=True)
        yield
    finally:
        process.terminate()
        process.wait(END_TIMEOUT)


def run_faults(output: Path, duration: float) -> list[str]:
    """Return what is not well about a run, and print what was measured.

    Parameters
    ----------
    output : Path
        Its folder.
    duration : float
        How long it was to last [s].
    """
    summary: dict[str, Any] = json.loads((output / "summary.json").read_text(encoding="utf-8"))
    latency = summary["timing"]["latency"]
    count = summary["messages"]["/measurement"]
    print(
        f"loop: {count} measurements in {summary['duration_s']:.1f} s, answered after "
        f"{latency['median_s'] * 1e3:.2f} ms (median) and {latency['p99_s'] * 1e3:.2f} ms (99 %); "
        f"{summary['reconfigurations']} reconfigurations"
    )
    faults = []
    if summary["duration_s"] < 0.9 * duration:
        faults.append(f"the bag has {summary['duration_s']:.1f} s of {duration:g} s")
    if latency["unanswered"] > 0.01 * count:
        faults.append(f"{latency['unanswered']} measurements have no answer")
    return faults


def _parameters(port: Path) -> list[str]:
    given = [f"drive.port:={port}", *CHECKED]
    return [word for text in given for word in ("-p", text)]


def _bdt(*arguments: object) -> int:
    return subprocess.run([*BDT, *map(str, arguments)], check=False).returncode  # noqa: S603


if __name__ == "__main__":
    main()
