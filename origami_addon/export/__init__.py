"""Exported files: models, arrays, drawings."""
