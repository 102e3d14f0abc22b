"""Photos, pages and kept results on disk: files in, arrays out, and back."""
