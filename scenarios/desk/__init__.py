"""The desk: runs, tables and studies as objects in Python and in notebooks."""
