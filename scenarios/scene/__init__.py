"""Scenes: their files, keys, parameters and expectations, read and checked."""
