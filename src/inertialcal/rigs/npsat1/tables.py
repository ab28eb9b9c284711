"""Figures of the published rate suite that the rig is built on, each with its table.

Columns are the axes x, y, z of the body. The thesis gives bias, start-up and matrix in one equation without a word on
sense; they are taken along the body axes, as that equation adds them up. Tables 2 and 15 stand in
``sensors.catalogue``; corrections of misprints follow the source audit.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011.
"""

from __future__ import annotations

import numpy as np

from ...sensors.catalogue import B_IN_RUN

# Table 3: bias in air [V] in powers of the temperature channel's volts; rows B, m1, m2, m3.
AMBIENT_VOLTS = np.array(
    [
        [-0.03562, -0.00295, 0.01428],
        [-0.05444, -0.01634, -0.01493],
        [-0.00816, -0.00622, -0.00899],
        [-0.00560, -0.00542, -0.00808],
    ]
)
# Table 7, repeated in Table 15: the same in vacuum.
VACUUM_VOLTS = np.array(B_IN_RUN).T

# Table 6: bias left after compensation with Table 3 [V], by region of pressure [Torr].
REGIONS_TORR = ((5.7e-7, 1.5e-6), (5.9e-6, 1e-5), (1e-5, 1e-4), (1e-4, 4e-4), (1e-3, 2e-3), (2e-3, 1e-2), (1e-2, 4e-2))
REGION_VOLTS = np.array(
    [
        [0.02221, 0.00327, 0.01893],
        [0.02808, 0.00209, 0.02039],
        [0.02211, 0.00297, 0.01949],
        [0.02091, 0.00291, 0.01834],
        [0.02899, 9.07e-04, 0.01942],
        [0.02921, 3.27e-04, 0.02141],
        [0.02821, 5.63e-04, 0.0218],
    ]
)
CONSTANT_BELOW_TORR = 4e-4  # section IV.C: constant from 1e-4 Torr down; the region above it reads the same
AIR_TORR = 760.0

# Appendices E to J: slopes [V/(deg/s)]; row = the sensor that reads, column = the axis that turns.
SLOPES = np.array(
    [
        [0.49979, -0.00115, -0.001],  # E1, F2, G2
        [5.08297e-4, 0.502, -6.93375e-4],  # E2, F1, J3 (G3 is a misprint of it)
        [0.00649, 6.37976e-4, 0.49747],  # E3, F3, G1
    ]
)

START_UP_AIR_DEG_S = (0.024, 0.017, 0.019)  # section IV.A: what is left out at the start, in air
START_UP_VACUUM_DEG_S = (0.02, 0.015, 0.016)  # section IV.C, in vacuum
SETTLED_AIR, SETTLED_VACUUM = 300.0, 4500.0  # Table 14: 5 min, and 1 to 1.5 h [s]
LARGEST_HYSTERESIS_DEG_S = 0.004  # section IV.B
LARGEST_RUN_TO_RUN_DEG_S = 0.016  # Table 14: about the largest difference seen
NOISE_DEG_S = 0.004  # Table 5, Appendix A: of an average of 1 s
WALK_DEG_H_SQRT_H = (5.817, 2.71, 2.71)  # Table 13, with the unit that the printed one is of; z is not printed
NOMINAL_SCATTER_V = 0.0011  # Table 2: of the temperature channel
QUALIFICATION_DEGC = (-29.0, 66.0)  # section IV.B, TVAC2-1a

LATE = {3: 0.018, 5: 1e-3, 6: 3e-4}  # steps [s] between saves and their share: ACS 206 and 238; the others are 2 s
