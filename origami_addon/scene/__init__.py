"""A document in a .blend: the Blender objects that arrays become, and what is read back from them."""
