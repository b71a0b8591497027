"""Names of the configurations that every installation has."""

SHIPPED = [
    "paper",
    "linear",
    "fixed_dead_zone",
    "laboratory",
    "simulated",
    "workshop",
    "serial_drive",
]
