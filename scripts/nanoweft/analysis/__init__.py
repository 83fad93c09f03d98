"""What states and tables tell: bundles, broken bonds, decays of energy."""
