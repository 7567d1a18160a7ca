"""Sweeps: one scene run many times with different values."""
