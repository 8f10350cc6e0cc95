"""The motion of a made-up chain of five segments, and what is recorded of it in the datasets' layouts."""

import numpy as np

from imubench.rotations import conjugate, from_axis_angle, log, multiply, rotate, rotate_back

AXES = {"2-3": 0, "3-4": 1, "4-5": 2}  # the hinge axis of each joint in the dataset's segment frame
G_W = np.array([0.0, 0.0, 9.81])


def base_quaternion(time):
    """A turn about several axes, smooth and far from its starting point."""
    yaw = from_axis_angle([0, 0, 1.0], 0.9 * np.sin(1.1 * time))
    return multiply(multiply(yaw, from_axis_angle([0, 1.0, 0], 0.7 * np.sin(1.7 * time))), pitch(time))


def pitch(time):
    return from_axis_angle([1.0, 0, 0], 0.8 * np.sin(2.3 * time + 0.4))


def chain_quaternions(time, mount=(1.0, 0, 0, 0)):
    """Five segments -> world; joints 2-3, 3-4, 4-5 are hinges x, y, z by 1.2 sin(...)."""
    q = [base_quaternion(time), multiply(base_quaternion(time), pitch(0.7 * time))]
    for k, axis in enumerate(np.eye(3)):
        q.append(multiply(q[-1], from_axis_angle(axis, joint_angle(time, k))))
    return [multiply(x, mount) for x in q]


def joint_angle(time, k):
    return 1.2 * np.sin((1.3 + 0.3 * k) * time + k)


def readings(time, k, delay=0.0):
    """Gyroscope and accelerometer of segment k + 1 (no translation), by central differences of its orientation."""
    h = 1e-4
    t = time - delay
    before, now, after = (chain_quaternions(x)[k] for x in (t - h, t, t + h))
    return log(multiply(conjugate(before), after)) / (2 * h), rotate_back(now, np.broadcast_to(G_W, (t.size, 3)))


def write_table(path, rate, columns, units="seconds/meters/radians/a.u."):
    rows = np.stack(list(columns.values()), axis=-1)
    lines = [",".join("" if np.isnan(x) else repr(float(x)) for x in row) for row in rows]
    head = [f"# sampling frequency: {rate}", f"# units are {units}", ",".join(columns)]
    path.write_text("\n".join(head + lines) + "\n")


def diodem_trial(folder, optical_late=0.0, optical_turn=(1.0, 0, 0, 0), units="seconds/meters/radians/a.u."):
    """Write a miniature trial; optical stamps late by `optical_late` s, its world turned by `optical_turn`."""
    folder.mkdir()
    t = np.arange(20 * 40) / 40
    imu = {}
    for k in range(5):
        gyro, accel = readings(t, k)
        imu |= {f"seg{k + 1}_acc_{c}": accel[:, i] for i, c in enumerate("xyz")}
        imu |= {f"seg{k + 1}_gyr_{c}": gyro[:, i] for i, c in enumerate("xyz")}
    write_table(folder / "imu_rigid.csv", 40, imu, units)
    write_table(folder / "imu_nonrigid.csv", 40, imu, units)
    stamps = np.arange(20 * 30) / 30
    omc = {}
    for k, q in enumerate(chain_quaternions(stamps - optical_late)):
        q = multiply(optical_turn, q)
        if k != 3:
            q[100:110] = np.nan  # the cameras lost the chain, and segment 4 was filled in
        omc |= {f"seg{k + 1}_quat_{c}": q[:, i] for i, c in enumerate("wxyz")}
    write_table(folder / "omc.csv", 30, omc)
    return folder


def constraint_rms(recording):
    """RMS of | |w1 x j| - |w2 x j| | in rad/s about the declared hinge axis."""
    across = [np.linalg.norm(np.cross(rotate(i.mount_quaternion, i.gyro), [0, 1, 0]), axis=-1) for i in recording.imus]
    return float(np.sqrt(np.mean((across[0] - across[1]) ** 2)))
