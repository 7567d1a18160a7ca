"""Scripted runs of the vehicle FMUs: scenes, the runner, results and the command line."""
