"""Photos, pages and kept results on the disk: files in, arrays out, and back."""
