"""The sheet as a relief over its flat page: a normal map and a displacement map."""
