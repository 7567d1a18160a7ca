"""What a scene says: its files, keys, parameters and expectations, read and checked."""
