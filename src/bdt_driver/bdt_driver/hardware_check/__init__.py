"""Checks of the contract between a drive and the driver node, on the hardware itself."""
