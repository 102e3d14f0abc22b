"""Creases: drawn or painted ones, where they end, their angles, the crease pattern."""
