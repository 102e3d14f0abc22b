"""Slow work, done by a separate Blender in the background to keep the window responsive."""
