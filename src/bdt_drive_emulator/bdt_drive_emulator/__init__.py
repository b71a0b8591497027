"""Emulator of a serial drive: the simulated mechanism behind a pseudo-terminal."""
