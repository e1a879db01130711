#!/usr/bin/env python3
"""Writes sh_table.csv: real spherical harmonics to l = 30, from SciPy's complex ones.

    pip install scipy && python3 sh_table.py > sh_table.csv        (written with SciPy 1.17.1)

SciPy's Y_l^m(theta, phi) is orthonormal and carries the Condon-Shortley phase (-1)^m, so that without the phase

    Y_l,m = (-1)^m sqrt(2) Re Y_l^m,   Y_l,-m = (-1)^m sqrt(2) Im Y_l^m,   Y_l,0 = Re Y_l^0          (m > 0)

The first line names the directions x y z, one a column; each further line is l, m and a value for each direction.
"""

from math import cos, pi, sin, sqrt

from scipy.special import sph_harm_y

MAX_L = 30
# theta from +z and phi from +x to +y: both poles, the equator on axes, next to a pole, and three in general position.
ANGLES = [(0, 0), (pi, 0), (pi / 2, 0), (pi / 2, -pi / 2), (1e-5, 2.5), (0.7, 1.9), (1.3, -0.4), (2.4, 3.7)]


def real_harmonic(l, m, theta, phi):
    value = sph_harm_y(l, abs(m), theta, phi)
    if m == 0:
        return value.real
    return (-1) ** m * sqrt(2) * (value.real if m > 0 else value.imag)


def direction(theta, phi):
    if sin(theta) < 1e-15:
        return "%d %d %d" % (0, 0, cos(theta))
    return "%.17g %.17g %.17g" % (sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta))


print("l,m," + ",".join(direction(*angles) for angles in ANGLES))
for l in range(MAX_L + 1):
    for m in range(-l, l + 1):
        values = (real_harmonic(l, m, *angles) for angles in ANGLES)
        print("%d,%d," % (l, m) + ",".join("%.14g" % (0 if abs(v) < 1e-14 else v) for v in values))
