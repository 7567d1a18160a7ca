"""Design studies: parameters that are best within bounds, and parameters that fit a measured signal."""
