"""Systems that users define, by a TOML file or a Python module of the same form as those of `models`."""
