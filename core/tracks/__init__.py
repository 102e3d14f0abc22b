"""Points of the sheet measured again, densely: its print aligned between all photos on the flat page."""
