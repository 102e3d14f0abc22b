"""Work that takes long, done by a Blender of its own in the background, so that the window stays free."""
