"""The console script ``bdt``: Ctrl-C ends it without a traceback from its first line on."""

import signal


def main() -> None:
    """Run the command; the console script ``bdt``."""
    ends = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if ends:
        # What follows imports modules for some tenths of a second; there is nothing to end yet.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from bdt_bringup.cli import main as run  # noqa: PLC0415

    if ends:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    run()


if __name__ == "__main__":
    main()
