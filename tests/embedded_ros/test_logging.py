"""The format of log lines, which rclpy reads once and embedded_ros at each line."""

import rclpy.logging


def test_the_format_can_be_chosen(capsys, monkeypatch):
    monkeypatch.setenv("RCUTILS_CONSOLE_OUTPUT_FORMAT", "{name}|{severity}|{message}|{what}")
    rclpy.logging.get_logger("a.b").fatal("text")
    assert capsys.readouterr().err == "a.b|FATAL|text|{what}\n"
