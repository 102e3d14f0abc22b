"""What a finished page becomes for others: text to search, METS and PAGE, IIIF. Needs neither Blender nor pycolmap."""
