// Nothing of its own: owns the headers that are compiled once for all tests.
