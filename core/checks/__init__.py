"""Whether what was found can be right: the placed photos, the sheet, its flat map, the page."""
