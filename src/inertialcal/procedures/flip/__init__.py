"""In-orbit flip: bias and ambient acceleration of a triaxial head from dwells at positions it is turned to."""
