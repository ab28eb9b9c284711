"""Models of sensors: made of the tests of a campaign, judged, found, shown and applied."""
