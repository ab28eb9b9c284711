"""How a unit lay: words, names of faces, the site."""
