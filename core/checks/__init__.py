"""Checks whether a result can be right: the placed photos, the sheet, its flat map, the page."""
