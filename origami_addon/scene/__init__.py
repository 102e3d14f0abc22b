"""A document in a .blend: turns arrays into Blender objects, and reads them back."""
