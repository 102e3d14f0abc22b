"""Any other mesh laid flat: cut open at its seams, each island flattened, all packed."""
