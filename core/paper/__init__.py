"""Where the sheet is: its region in the scene, the reference photo, the paper's edge in it, the points on it."""
