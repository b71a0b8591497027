"""Traps by declared and by expanded sizes, read by a process that may not have much memory."""

import subprocess
import sys

from backports import zstd

GIGABYTE = 2**30

READ = f"""
import resource, sys
from bdt_bringup.cli import run_command
resource.setrlimit(resource.RLIMIT_AS, (2 * {GIGABYTE}, 2 * {GIGABYTE}))
sys.exit(max(run_command(["analyze", bag]) != 2 for bag in sys.argv[1:]))
"""


def zeros(blocks: int) -> bytes:
    """Return a zstd frame of blocks that say 128 KiB of zeros in four bytes each."""
    block, last = ((2**17 << 3 | 1 << 1 | end).to_bytes(3, "little") + b"\0" for end in (0, 1))
    return b"\x28\xb5\x2f\xfd\x00\x58" + block * (blocks - 1) + last


def test_frame_of_zeros():
    assert zstd.decompress(zeros(3)) == bytes(3 * 2**17)


def test_traps_end_with_one_line(tmp_path, mcap):
    trap = zeros(4 * GIGABYTE // 2**17)
    header = mcap.record(1, b"\x04\0\0\0ros2\0\0\0\0")
    traps = {
        "honest.mcap": mcap.file(header, mcap.chunk(b"", "", declared=4 * GIGABYTE)),
        "lying.mcap": mcap.file(header, mcap.chunk_of(trap, "zstd", 1000)),
        "true.mcap": mcap.file(header, mcap.chunk_of(trap, "zstd", 4 * GIGABYTE)),
        "whole.mcap.zstd": trap,
        "record.mcap": mcap.file(header, b"\x05" + (4 * GIGABYTE).to_bytes(8, "little")),
    }
    for name, content in traps.items():
        (tmp_path / name).write_bytes(content)
    result = subprocess.run(
        [sys.executable, "-c", READ, *(str(tmp_path / name) for name in traps)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    lines = result.stderr.splitlines()
    assert result.returncode == 0, result.stderr
    assert [line.split(": ")[:2] for line in lines] == [
        ["error", f"bag {tmp_path / name}"] for name in traps
    ]
