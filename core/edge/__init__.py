"""The paper's edge in all photos."""
