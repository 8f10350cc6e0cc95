"""MuJoCo plays a rig; an IMU model turns its truth into a recording."""
