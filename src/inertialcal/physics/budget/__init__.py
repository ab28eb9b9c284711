"""Budget of the acceleration that a moved mass applies."""
