"""The page image from all photos: each part from those that show it best."""
