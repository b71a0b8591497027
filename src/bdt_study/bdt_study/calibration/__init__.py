"""Constants of a machine from a minute of its telemetry."""
