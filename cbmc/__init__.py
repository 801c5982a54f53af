"""CBMC-V3: five spiking modules on three levels that learn online.

All modules work alike: made from the paper's table, joined to the two pathways by ``connect``, then called without
arguments; they read the ascending pathway's arrays and refill the descending pathway's in place.
"""
