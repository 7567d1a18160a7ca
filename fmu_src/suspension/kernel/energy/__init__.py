"""What elements dissipate and store, and what roads and loads do."""
