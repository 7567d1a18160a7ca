"""A system as numbers: its elements in their branches, roads and loads, friction that sticks, rest."""
