"""What the report tells a stranger about the run."""

from imubench.reproduce.arve import figure4, figure5, figure6, figure7, figure8, figure9, tables
from imubench.reproduce.arve.results import Results
from imubench.reproduce.arve.runs import WAYS
from imubench.reproduce.paper import Story


def tell(r: Results) -> Story:
    """Return the setting, figures and tables in the paper's order, and the readings taken."""
    s = r.settings
    seeds = s.seeds()
    told = {way: r.distance(way, "varying", "arve-d") for way in ("told", "ukf")}
    setting = (
        "The paper finds r, the vector from an inertial sensor on a limb to the centre of the joint that it swings "
        "about, from that one sensor, sample by sample, while soft tissue lets the sensor wander. Its synthetic "
        "experiments are rebuilt here: a spherical pendulum on an ellipse (17, 9 and 3 deg about x, y and z, periods "
        "1, 1 and 1.5 s), r = (-60, 20, 200) mm constant or varying by 20, 5 and 20 mm at 1 Hz, 10 s at 100 Hz, white "
        "noise of 0.0017 rad/s and 0.02 m/s^2. Compared are two extended Kalman filters, ArVE (state r, w, w') and "
        "ArVE_d (r' besides), and MrVS, one r by least squares for a record or for a sliding window. Errors: |dr|, the "
        "length of the difference; d|r|, the difference of the lengths; the angle between both. "
        f"{s.runs} runs differ in their noise, seeds {seeds[0]} to {seeds[-1]}; the covariances, which the paper does "
        "not publish, were fitted once on seed 100. Gravity is taken out by an unscented Kalman filter that is told "
        "its first orientation. That is a reading, and it decides: not told, ArVE_d would be "
        f"{told['ukf']:.1f} mm off instead of {told['told']:.1f} mm."
    )
    notes = (
        "The paper does not say how its orientation filter starts. Told is the reading under which its table is "
        "reproduced; the table beside it has the others.",
        "r = (-60, 20, 200) mm is that of the text, along the limb; captions and table I say (200, 20, -60).",
        "The gyroscope's noise, printed as 0.0017 deg/s, is read as rad/s: the sensor's density times the root of the "
        "rate gives that, and deg/s would be 57 times quieter than any such sensor.",
        "Equation 5 prints a = M r; with equations 1, 4 and 6 it is a = -M r. w' for MrVS is the central difference.",
        "In the varying experiment the accelerometer does not feel that r varies, as the paper assumes.",
        "Fitted was the driving noise of w' and of r or r', by the least mean |dr| of one run with a known "
        "orientation; for a constant r all covariances are argued. estimators/arve_covariances.toml has them.",
        f"Ways to take gravity out: {'; '.join(WAYS[way] for way in s.ways)}.",
    )
    exhibits = (
        figure4.exhibit(r),
        tables.readings(r),
        *(module.exhibit(r) for module in (figure5, figure6, figure7, figure8)),
        tables.table1(r),
        tables.gravity(r),
        figure9.exhibit(r),
    )
    return Story(setting, exhibits, notes)
