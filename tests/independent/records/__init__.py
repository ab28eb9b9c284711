"""Records that the gate tries: clean ones, bases that faults are put into, and an examiner's variations of faults."""
