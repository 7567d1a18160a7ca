"""From scenes and results to constructions, pictures, portraits and recordings."""
