"""Whether a result can be right, and how exact it is: pairs of photos, the sheet, its flat map, the page."""
