"""From the sheet to flat coordinates: the flatteners, pinned vertices, the four sides, stretch."""
