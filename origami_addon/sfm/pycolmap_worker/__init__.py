"""What the worker does, in a process without Blender: numpy and pycolmap, and nothing of the package."""
