"""A test bench for inertial joint calibration.

Data flows one way::

    scenario -> simulate -> Truth -> observe -> Recording -> estimate -> Estimate -> score -> log

A `Recording` from a laboratory and one from the simulator are the same type.
Estimators see a `Recording` and nothing else; `Truth` only judges them.

Conventions, the same everywhere
--------------------------------
Units       SI and radians. Another unit appears only in a name at the border
            (``rate_deg_s``).
Quaternions ``w, x, y, z``; ``q_ws`` turns sensor coordinates into world
            coordinates, and so does the rotation matrix ``R_ws``.
World       z up, gravity (0, 0, -9.81) m/s^2 unless a recording says otherwise.
Accelerometer  reads specific force ``f = R_ws^T (a - g)``: at rest it points up.
Gyroscope   reads the angular rate of the sensor in sensor axes.
Hinge rig   both segment frames have their origin in the joint centre and +y along
            the hinge axis; segment 1 extends along -x, segment 2 along +x. The
            hinge angle turns segment 2 relative to segment 1 about +y.
Pendulum    the segment frame has its origin in the pivot; at rest the limb hangs
            along -z.
Mount       (position of the sensor in the segment frame, quaternion sensor -> segment).
Joint vector ``r`` points from the sensor to the joint centre, in the sensor frame.
Suffixes    ``_s`` in sensor axes, ``_b`` in segment axes, ``_w`` in world axes;
            ``_std`` per sample, ``_density`` per root hertz.
"""

__version__ = "0.1.0"
