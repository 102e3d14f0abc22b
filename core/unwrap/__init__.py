"""Unwraps any other mesh: cuts it open at its seams, flattens each island, packs all of them."""
