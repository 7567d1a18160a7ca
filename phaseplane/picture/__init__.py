"""What a picture of a construction shows, free of any canvas: pages, letters, words and styles."""
