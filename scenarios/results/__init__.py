"""Results of a run: tables, folders, reports and comparisons."""
