"""From flat coordinates to the page: laid out upright, its image taken from the photos and healed."""
