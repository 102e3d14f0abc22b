"""From points to the sheet in space: a smooth grid of depths, sharp along creases, cut out as a mesh."""
