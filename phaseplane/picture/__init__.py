"""The content of a picture of a construction, for any canvas: pages, letters, texts and styles."""
