"""Subcommands of ``bdt`` that this package brings."""
