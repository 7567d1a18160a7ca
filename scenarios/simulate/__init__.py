"""A scene simulated: its FMU packed or found, driven by FMPy, or its equation solved."""
