"""A user in front of Blender's own window, played by a script: `make test-blender`."""
