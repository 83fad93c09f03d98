"""Checks of nanoweft against closed forms and conservation laws, one file for each family."""
from . import (
    bending, bond_laws, box, buckling, contacts, energy, folded, holders, kinds, links, rest,
    segment_length, surfaces, temperature, torsion, tubes, twisted, vibration)

ALL = {**bending.CHECKS, **buckling.CHECKS, **vibration.CHECKS, **torsion.CHECKS, **twisted.CHECKS,
       **tubes.CHECKS, **folded.CHECKS, **energy.CHECKS, **segment_length.CHECKS, **kinds.CHECKS,
       **rest.CHECKS, **links.CHECKS, **bond_laws.CHECKS, **surfaces.CHECKS, **contacts.CHECKS,
       **box.CHECKS, **holders.CHECKS, **temperature.CHECKS}
