"""Tools for all packages of the core: images, polygons, triangles, robust least squares."""
