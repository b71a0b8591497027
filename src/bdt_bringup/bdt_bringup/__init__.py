"""The command ``bdt``: finds subcommands and nodes by name, starts and watches the loop."""
