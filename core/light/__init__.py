"""The light on the sheet: what it is at each place of the page, and the page without it."""
