"""Runs as hosts see them: inputs between samples, outputs, energies, and many runs in a row."""
