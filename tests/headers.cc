// Empty: owns the headers that are precompiled for all tests.
