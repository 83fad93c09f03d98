"""What the commands in scripts/ are made of.

states       state files: read, write, the tubes in them
kinds        kinds of segments: names, radii
tables       CSV tables, with or without lines of provenance
options      option files and options as words of a command
runs         runs of the program with the environment of scripts/environment
beams        closed forms of springs, ladders, kinks
generators   fibres laid in space, to write as states
scenes       scenes that the program lays, to be moved, turned and mixed
rotations    quaternions and matrices of many segments
units        times, lengths and energies as people write them
arguments    kinds of arguments that several commands take
analysis     orientation, bundles, porosity, contacts, shapes, pores, broken bonds, stresses, decays
pictures     tubes as pictures and movies, tables as plots
report       one HTML page of a run
published    numbers that others published, which scenes and tests measure anew
verification, speed_error, scaling   the three studies with pages of their own in runs/
"""
