"""The loop over steps: proposed, tried, accepted."""
