"""Subcommands of ``bdt`` that study the loop offline."""
