"""One step of the gravity filter of gravity.py for one run, in plain numbers: a fifth of the time of arrays of three.

Sigma points come in pairs +-e, along the columns of the root of the covariance. With u what gravity reads as,
R(e)^T u = c + s with the part c = u cos|e| + e (e.u) (1 - cos|e|) / |e|^2 that both of a pair share and the part
s = -(e x u) sin|e| / |e| that has the other sign at the other. So the mean is that of c, the covariance with the error
is the mean of e s^T, and that of what is read is the mean of (c - mean)(c - mean)^T + s s^T.
"""

import math

Three = tuple[float, float, float]
Four = tuple[float, float, float, float]
Nine = tuple[float, float, float, float, float, float, float, float, float]
"""A matrix (3, 3), row by row."""
EYE: Nine = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
NONE: Nine = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def turned(v: Three) -> Four:
    """Return the quaternion of a rotation vector in rad."""
    x, y, z = v
    angle = math.sqrt(x * x + y * y + z * z)
    k = math.sin(angle / 2) / angle if angle > 1e-9 else 0.5
    return math.cos(angle / 2), k * x, k * y, k * z


def product(p: Four, q: Four) -> Four:
    """Return the Hamilton product p q."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def matrix(q: Four) -> Nine:
    """Return the rotation matrix of a unit quaternion."""
    w, x, y, z = q
    return (
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    )


def times(A: Nine, B: Nine) -> Nine:
    """Return A B."""
    a, b, c, d, e, f, g, h, i = A
    r, s, t, u, v, w, x, y, z = B
    return (
        a * r + b * u + c * x,
        a * s + b * v + c * y,
        a * t + b * w + c * z,
        d * r + e * u + f * x,
        d * s + e * v + f * y,
        d * t + e * w + f * z,
        g * r + h * u + i * x,
        g * s + h * v + i * y,
        g * t + h * w + i * z,
    )


def transposed(A: Nine) -> Nine:
    """Return A^T."""
    a, b, c, d, e, f, g, h, i = A
    return a, d, g, b, e, h, c, f, i


def columns(x: Three, y: Three, z: Three) -> Nine:
    """Return the matrix with these columns."""
    return x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]


def combined(A: Nine, k: float, B: Nine) -> Nine:
    """Return A + k B."""
    a, b, c, d, e, f, g, h, i = A
    r, s, t, u, v, w, x, y, z = B
    return a + k * r, b + k * s, c + k * t, d + k * u, e + k * v, f + k * w, g + k * x, h + k * y, i + k * z


def outer(u: Three, v: Three) -> Nine:
    """Return u v^T."""
    a, b, c = u
    x, y, z = v
    return a * x, a * y, a * z, b * x, b * y, b * z, c * x, c * y, c * z


def seen(P: Nine, R: Nine) -> Nine:
    """Return R^T P R: a covariance in axes turned by R."""
    return times(transposed(R), times(P, R))


def up(q: Four, gravity: float) -> Three:
    """Return what an accelerometer at rest reads, in sensor axes."""
    w, x, y, z = q
    return 2 * gravity * (x * z - w * y), 2 * gravity * (y * z + w * x), gravity * (1 - 2 * (x * x + y * y))


def predicted(q: Four, P: Nine, turn: Three, variance: float) -> tuple[Four, Nine]:
    """Return orientation and covariance after a turn in rad, in which each axis gathers a variance in rad^2."""
    by = turned(turn)
    return product(q, by), combined(seen(P, matrix(by)), variance, EYE)


def corrected(q: Four, P: Nine, f: Three, gravity: float, variance: float) -> tuple[Four, Nine]:
    """Return both after a specific force f in m/s^2 was taken for gravity, with noise of `variance`."""
    u, points = up(q, gravity), _points(P)
    (c1, s1), (c2, s2), (c3, s3) = (_parts(e, u) for e in points)
    even, odd, errors = columns(c1, c2, c3), columns(s1, s2, s3), columns(*points)
    mean = (c1[0] + c2[0] + c3[0]) / 3, (c1[1] + c2[1] + c3[1]) / 3, (c1[2] + c2[2] + c3[2]) / 3
    squares = combined(times(even, transposed(even)), 1.0, times(odd, transposed(odd)))
    S = combined(combined(outer(mean, (-mean[0], -mean[1], -mean[2])), 1 / 3, squares), variance, EYE)
    C = combined(NONE, 1 / 3, times(errors, transposed(odd)))
    gain = times(C, _inverse(S))
    a, b, c_, d, e_, f_, g, h, i = gain
    x, y, z = f[0] - mean[0], f[1] - mean[1], f[2] - mean[2]
    step = a * x + b * y + c_ * z, d * x + e_ * y + f_ * z, g * x + h * y + i * z
    w, x, y, z = product(q, turned(step))
    size = math.sqrt(w * w + x * x + y * y + z * z)
    # what is left of the error is seen in axes turned by half of the step
    half = matrix(turned((step[0] / 2, step[1] / 2, step[2] / 2)))
    left = seen(combined(P, -1.0, times(gain, transposed(C))), half)
    return (w / size, x / size, y / size, z / size), combined(combined(NONE, 0.5, left), 0.5, transposed(left))


def _points(P: Nine) -> tuple[Three, Three, Three]:
    """Return the columns of the lower root of 3 P."""
    xx, yx, yy, zx, zy, zz = 3 * P[0], 3 * P[3], 3 * P[4], 3 * P[6], 3 * P[7], 3 * P[8]
    a = math.sqrt(xx)
    b, c = yx / a, zx / a
    d = math.sqrt(yy - b * b)
    e = (zy - b * c) / d
    return (a, b, c), (0.0, d, e), (0.0, 0.0, math.sqrt(zz - c * c - e * e))


def _parts(e: Three, u: Three) -> tuple[Three, Three]:
    """Return c and s of R(e)^T u."""
    x, y, z = e
    a, b, c = u
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    cosine = math.cos(angle)
    k = (x * a + y * b + z * c) * ((1 - cosine) / square if angle > 1e-4 else 0.5)  # 1e-9 of it are left out
    j = math.sin(angle) / angle if angle > 1e-9 else 1.0
    along = a * cosine + x * k, b * cosine + y * k, c * cosine + z * k
    return along, (j * (z * b - y * c), j * (x * c - z * a), j * (y * a - x * b))


def _inverse(S: Nine) -> Nine:
    """Return the inverse of a symmetric matrix."""
    xx, xy, xz, _, yy, yz, _, _, zz = S
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    k = 1 / (xx * a + xy * b + xz * c)
    d, e, f = (xx * zz - xz * xz) * k, (xy * xz - xx * yz) * k, (xx * yy - xy * xy) * k
    a, b, c = a * k, b * k, c * k
    return a, b, c, b, d, e, c, e, f
