"""Tools of all rooms: images, polygons, triangles, robust least squares."""
