"""Checks of nanoweft against closed forms, one file for each family."""
from . import bending, buckling, folded, torsion, tubes, twisted, vibration

ALL = {**bending.CHECKS, **buckling.CHECKS, **vibration.CHECKS, **torsion.CHECKS, **twisted.CHECKS,
       **tubes.CHECKS, **folded.CHECKS}
