#!/usr/bin/env python3
# Prints the polynomials and tables of include/ticktrue/math.h as C. Needs mpmath; no build and no test runs it.
# SPDX-License-Identifier: MIT
# Source of the method: E. Ya. Remez, 1934 (exchange of extrema). Every number below follows from the function alone.
import struct
from mpmath import mp, mpf, matrix, lu_solve, sin, cos, exp, log, atan, asin, sqrt, pi, floor, nint, taylor

mp.dps = 60


def bits(x):
    return struct.unpack('<Q', struct.pack('<d', float(x)))[0]


def rounded_to(x, lsb):
    """The multiple of 2^lsb nearest to x."""
    return nint(mpf(x) * mpf(2) ** -lsb) * mpf(2) ** lsb


def remez(function, weight, low, high, count):
    """Coefficients, and the largest weight * |polynomial - function|."""
    low, high = mpf(low), mpf(high)
    points = [(low + high) / 2 - (high - low) / 2 * cos(pi * (2 * i + 1) / (2 * (count + 1))) for i in range(count + 1)]
    grid = [(low + high) / 2 - (high - low) / 2 * cos(pi * i / (60 * count)) for i in range(60 * count + 1)]
    values = [(x, function(x), weight(x)) for x in grid]
    for _ in range(12):
        system, right = matrix(count + 1), matrix(count + 1, 1)
        for row, x in enumerate(points):
            for column in range(count):
                system[row, column] = x ** column
            system[row, count] = (-1) ** row / weight(x)
            right[row] = function(x)
        found = lu_solve(system, right)
        coefficients = [found[i] for i in range(count)]
        errors = [(x, w * (sum(c * x ** i for i, c in enumerate(coefficients)) - f)) for x, f, w in values]
        extrema = [errors[0]]
        for x, error in errors[1:]:
            if (error > 0) == (extrema[-1][1] > 0):
                if abs(error) > abs(extrema[-1][1]):
                    extrema[-1] = (x, error)
            else:
                extrema.append((x, error))
        while len(extrema) > count + 1:
            extrema.pop(0 if abs(extrema[0][1]) < abs(extrema[-1][1]) else -1)
        if len(extrema) < count + 1:
            break
        points = [x for x, _ in extrema]
    worst = max(abs(w * (sum(mpf(float(c)) * x ** i for i, c in enumerate(coefficients)) - f)) for x, f, w in values)
    return coefficients, worst


def ratio(numerator, power):
    """numerator(x) / x^power where x may be 0 or close to it: a Taylor series there."""
    series = taylor(numerator, 0, power + 24)

    def value(x):
        if abs(x) > 0.02:
            return numerator(x) / x ** power
        return sum(c * x ** i for i, c in enumerate(series[power:]))
    return value


def in_square(function, power):
    """function(r) / r^power as a function of z = r^2, for a function with terms of one parity."""
    inner = ratio(function, power)
    return lambda z: inner(sqrt(z))


def polynomial(name, function, weight, low, high, count):
    coefficients, worst = remez(function, weight, low, high, count)
    print('/* %s: %d coefficients, 2^%.1f */' % (name, count, float(log(worst, 2))))
    print('  ' + ',\n  '.join('%.17g' % float(c) for c in coefficients))


def table(name, rows, width):
    print('static const uint64_t %s[%d] = {' % (name, len(rows)))
    for start in range(0, len(rows), width):
        print('    ' + ', '.join('0x%016xu' % row for row in rows[start:start + width]) + ',')
    print('};')


def log_rows():
    """Of each of 128 intervals: 1/c with 9 bits after the point, -log(1/c) as a multiple of 2^-42 and its rest."""
    rows, low, high = [], mpf(0), mpf(0)
    offset = 0x3fe6000000000000
    for i in range(128):
        def value(b):
            z = struct.unpack('<d', struct.pack('<Q', b))[0]
            return z
        first, last = None, None
        start = offset + (i << 45)
        z = value(start)
        end = value(start + (1 << 45) - 1)
        middle = (mpf(z) + mpf(end)) / 2
        inverse = rounded_to(1 / middle, -9)
        if z == 1.0 or value(start + (1 << 45)) == 1.0:
            inverse = mpf(1)
        low, high = min(low, z * inverse - 1), max(high, end * inverse - 1)
        logarithm = -log(inverse)
        head = rounded_to(logarithm, -42)
        rows += [bits(inverse), bits(head), bits(logarithm - head)]
    return rows, low, high


def main():
    quarter = pi / 4 * mpf('1.0001')
    polynomial('sin', in_square(lambda r: sin(r) - r, 3), lambda z: z, 0, quarter ** 2, 6)
    polynomial('cos', in_square(lambda r: cos(r) - 1 + r * r / 2, 4), lambda z: z * z, 0, quarter ** 2, 6)
    polynomial('sinf', in_square(lambda r: sin(r) - r, 3), lambda z: z, 0, quarter ** 2, 4)
    polynomial('cosf', in_square(lambda r: cos(r) - 1 + r * r / 2, 4), lambda z: z * z, 0, quarter ** 2, 4)
    step = log(mpf(2)) / 256 * mpf('1.001')
    polynomial('exp', ratio(lambda r: exp(r) - 1 - r, 2), lambda r: r * r + mpf(10) ** -12, -step, step, 4)
    polynomial('expf', ratio(lambda r: exp(r) - 1 - r, 2), lambda r: r * r + mpf(10) ** -12, -step, step, 2)
    rows, low, high = log_rows()
    print('/* log: r in %.6f .. %.6f */' % (float(low), float(high)))
    tail = ratio(lambda r: log(1 + r) - r + r * r / 2, 3)
    for name, count in (('log', 5), ('pow', 6)):
        polynomial(name, tail, lambda r: r * r + mpf(10) ** -12, low, high, count)
    polynomial('logf', ratio(lambda r: log(1 + r) - r, 2), lambda r: abs(r) + mpf(10) ** -9, low, high, 4)
    polynomial('atan', in_square(lambda s: atan(s) - s, 3), lambda z: z, 0, mpf('0.0626') ** 2, 5)
    polynomial('atanf', in_square(lambda s: atan(s) - s, 3), lambda z: z, 0, 1, 11)
    for name, count in (('asin', 13), ('asinf', 7)):
        polynomial(name, in_square(lambda x: asin(x) - x, 3), lambda z: z, 0, mpf('0.25'), count)

    table('ttm_exp_table', [b for i in range(128) for b in (
        bits(mpf(2) ** (mpf(i) / 128)), bits(mpf(2) ** (mpf(i) / 128) / mpf(float(mpf(2) ** (mpf(i) / 128))) - 1))], 4)
    table('ttm_log_table', rows, 3)
    arcs = [atan(mpf(2) ** e * (1 + mpf(2 * j + 1) / 16)) for e in range(-4, 4) for j in range(8)]
    table('ttm_atan_table', [b for arc in arcs for b in (bits(arc), bits(arc - mpf(float(arc))))], 4)
    mp.dps = 500
    two_over_pi = 2 / pi
    table('ttm_two_over_pi', [int(floor(two_over_pi * mpf(2) ** (64 * (i + 1)))) % (1 << 64) for i in range(20)], 4)
    mp.dps = 60

    def parts(name, value, lsbs):
        rest = value
        for i, lsb in enumerate(lsbs):
            part = rounded_to(rest, lsb) if lsb is not None else mpf(float(rest))
            print('#define %s_%d %.17g' % (name, i, float(part)))
            rest -= part
    parts('TTM_HALF_PI', pi / 2, [-32, -65, -98, None])
    parts('TTM_HALF_PI_PAIR', pi / 2, [None, None])
    parts('TTM_PI_PAIR', pi, [None, None])
    parts('TTM_LN2', log(mpf(2)), [-42, None])
    parts('TTM_LN2_128', log(mpf(2)) / 128, [-42, None])
    print('#define TTM_TWO_OVER_PI %.17g' % float(2 / pi))
    print('#define TTM_128_OVER_LN2 %.17g' % float(128 / log(mpf(2))))


main()
