"""What states and tables tell: orientation, bundles, porosity, contacts, broken bonds, decays."""
