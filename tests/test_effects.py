"""Every effect in the registry: named as the table has it, silent at zero, its Jacobian exact."""

from collections import defaultdict

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from imubench import rotations
from imubench.diagnosis.problem.bspline import Moment
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.problem.motion_prior import prior_rows
from imubench.diagnosis.problem.rig_kinematics import ATTITUDE, swing
from imubench.diagnosis.solve.gauss_newton import equation_rows
from imubench.diagnosis.solve.initialize import model_of
from imubench.diagnosis.solve.linearize import linearise
from imubench.effects import EFFECTS, VARIANTS
from imubench.effects.effect import Reading, Scene
from imubench.effects.library import numbers_lacking
from imubench.errors import InputError
from imubench.jets import Jet, Turn, rotation
from imubench.links import Link, Motion, shift
from imubench.models import RIG_FILES
from imubench.models.tree import rig_tree
from imubench.recording import Body, Encoder, Imu, Pose, Recording

RATE, SECONDS = 25.0, 0.6
GRAVITY = np.array([0.0, 0.0, -9.81])
BODY = Body(mass=1.2, com=[0.05, 0.02, -0.25], inertia=[0.03, 0.028, 0.002])


def recording_of(rig, **changes):
    rng = np.random.default_rng(8)
    time = np.arange(0.013, SECONDS, 1 / RATE)
    names = ("imu1", "imu2") if rig == "hinge" else ("imu1",)
    imus = tuple(
        Imu(n, time + 0.003 * i, rng.normal(size=(len(time), 3)), rng.normal(size=(len(time), 3)), RATE,
            mount_position=rng.normal(size=3) * 0.1, mount_quaternion=rotations.random(rng))
        for i, n in enumerate(names)
    )  # fmt: skip
    swinging = rig != "free"
    encoders = (Encoder("hinge", time, rng.normal(size=len(time))),) if rig == "hinge" else ()
    given = {"imus": imus, "encoders": encoders, "body": BODY if swinging else None}
    return Recording("r", rig, **given | {"free_swings": ((0.0, SECONDS),) if swinging else ()} | changes)


def model_with(effect, rig, **changes):
    recording = recording_of(rig, **changes)
    places = effect.places(recording)
    model = model_of(recording, knots_per_s=20.0)
    return model.with_effects((Hypothesis(effect, places[-1]),)) if places else None


def random_state(model, rng, size=0.5):
    """A motion of some rad/s about level, every parameter half a prior's std from its start."""
    tracks = model.tracks
    coefficients = 0.3 * rng.normal(size=(tracks.knots.count, tracks.width))
    if ATTITUDE in tracks.widths:
        coefficients[:, tracks.columns(ATTITUDE)] *= 0.3
        coefficients[:, tracks.columns(ATTITUDE)] += [1.0, 0.0, 0.0, 0.0]
    for h in model.hypotheses:
        for s in h.effect.states:
            coefficients[:, tracks.columns(h.key(s.name))] = s.std * rng.normal(size=(tracks.knots.count, s.width))
    values = {}
    for name, prior in model.priors.items():
        known = any(name.startswith(h.name) for h in model.hypotheses)
        values[name] = prior.start + size * (prior.std if known else 0.01) * rng.normal(size=len(prior.start))
        if name.endswith((".time", ".angle")):
            values[name][:] = 0.21 if name.endswith(".time") else 0.05  # within the recording; within reach
    return State(coefficients, values)


def every_row(model, state):
    """Measurements and laws; what the joint's centre obeys is the one prior that an effect enters."""
    drift = [r for r in prior_rows(model, state, defaultdict(lambda: 1.0), None) if r.name == "drift"]
    return [*model.measured(state), *equation_rows(model, state), *drift]


TABLE = {  # names, places and shapes as the laboratory's scripts know them
    "gyro_bias": ("imu", {"bias": (3,)}),
    "accel_bias": ("imu", {"bias": (3,)}),
    "gyro_drift": ("imu", {"rate": (3,)}),
    "accel_drift": ("imu", {"rate": (3,)}),
    "gyro_scale": ("imu", {"scale": (3,)}),
    "accel_scale": ("imu", {"scale": (3,)}),
    "gyro_misalignment": ("imu", {"matrix": (6,)}),
    "accel_misalignment": ("imu", {"matrix": (6,)}),
    "g_sensitivity": ("imu", {"matrix": (3, 3)}),
    "time_offset": ("imu", {"offset": ()}),
    "clock_skew": ("imu", {"skew": ()}),
    "mount_pose": ("imu", {"rotation": (3,), "translation": (3,)}),
    "mount_shift": ("imu", {"rotation": (3,), "translation": (3,), "time": ()}),
    "soft_mount": ("imu", {"frequency": (3,), "damping_ratio": ()}),
    "rocking_mount": (
        "imu",
        {"frequency": (3,), "damping_ratio": (3,), "com": (3,), "lever": (3,), "gyration": ()},
    ),
    "skin_sliding": ("imu", {"slide": (3,), "twist": (3,)}),
    "joint_play": ("joint", {"range": (), "direction": ()}),
    "axis_coupling": ("joint", {"coupling": (2,)}),
    "moving_centre": ("joint", {"slide": (3,)}),
    "moving_pivot": ("joint", {"std": (), "band": (2,)}),
    "gyro_noise": ("imu", {"std": ()}),
    "accel_noise": ("imu", {"std": ()}),
    "low_pass": ("imu", {"cutoff": (), "channels": ()}),
    "saturation": ("imu", {"limit": (), "channels": ()}),
    "quantisation": ("imu", {"step": (), "channels": ()}),
    "dropouts": ("imu", {"fraction": (), "mode": ()}),
    "vibration": ("imu", {"frequency": (), "amplitude": (3,)}),
    "impacts": ("imu", {"times": (None,)}),
    "viscous_friction": ("joint", {"c": ()}),
    "dry_friction": ("joint", {"t": ()}),
    "air_drag": ("joint", {"d": ()}),
    "joint_spring": ("joint", {"k": (), "q0": ()}),
    "end_stop": ("joint", {"angle": ()}),
    "backlash": ("joint", {"range": ()}),
    "inertia": ("body", {"scale": ()}),
    "gravity": ("world", {"g": ()}),
}
ONE = {"soft_mount": {"frequency"}, "rocking_mount": {"frequency", "damping_ratio"}}  # (3) or (1)
CASES = [
    pytest.param(effect, rig, id=f"{effect.name}-{effect.variant or 'usual'}-{rig}")
    for effect in VARIANTS
    for rig in RIG_FILES
    if effect.places(recording_of(rig)) and (effect.parameters or effect.states)
]
SILENT = [c for c in CASES if c.values[0].name != "low_pass"]  # a filter's state is what it lets through


def test_names_places_and_parameters_are_the_tables():
    assert list(EFFECTS) and set(EFFECTS) == set(TABLE)
    for effect in VARIANTS:
        place, parameters = TABLE[effect.name]
        assert effect.place == place
        shapes = {p.name: p.shape for p in effect.parameters if p.reported} | {f.name: f.shape for f in effect.found}
        for name in effect.settings:
            shapes[name] = ()
        for name in ONE.get(effect.name, ()) if effect.variant else ():
            assert shapes[name] == (1,)
            shapes[name] = (3,)
        assert shapes == parameters, effect.name
        assert effect.law and effect.__doc__


def test_no_two_effects_share_a_name_and_a_setting():
    names = [Hypothesis(e, "imu1").name for e in VARIANTS]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize(("effect", "rig"), SILENT)
def test_zero_leaves_every_row_as_it_is(effect, rig):
    model = model_with(effect, rig)
    state = random_state(model, np.random.default_rng(2))
    for h in model.hypotheses:
        for s in h.effect.states:
            state.coefficients[:, model.tracks.columns(h.key(s.name))] = 0.0
        for p in effect.parameters:
            state.values[h.key(p.name)][:] = p.centre
    bare = model.with_effects(())
    plain = State(state.coefficients[:, : bare.tracks.width], state.values)
    own = {h.key(law) for h in model.hypotheses for law in ("balance", "gyro", "accel", "gap")}
    rows = [r for r in every_row(model, state) if r.name not in own]
    for got, expected in zip(rows, every_row(bare, plain), strict=True):
        assert_allclose(got.residual.value, expected.residual.value, atol=1e-9, err_msg=got.name)  # rounding


def along(linear, model, coefficients, values):
    """The rows' derivative in a direction, from their blocks."""
    moved = linear.along(coefficients[:, :, None])[:, :, 0]
    for name, value in values.items():
        moved += linear.border[:, :, model.parameters.columns(name)] @ value
    return moved


def directions(model, rng):
    """One direction in every spline and every parameter, of a size with their priors."""
    tracks, none = model.tracks, np.zeros((model.tracks.knots.count, model.tracks.width))
    for name, width in tracks.widths.items():
        change = none.copy()
        change[:, tracks.columns(name)] = 0.1 * rng.normal(size=(len(none), width))
        yield name, change, {}
    for name, prior in model.priors.items():
        yield name, none, {name: prior.std * rng.normal(size=len(prior.start))}


@pytest.mark.parametrize(("effect", "rig"), CASES)
def test_blocks_are_finite_differences_of_the_whole_model(effect, rig):
    model, rng = model_with(effect, rig), np.random.default_rng(7)
    state, step = random_state(model, rng), 1e-6
    rows = every_row(model, state)
    linear = [linearise(row, model.tracks, model.parameters) for row in rows]
    felt = set()
    for what, change, values in directions(model, rng):
        ends = [
            every_row(
                model,
                State(
                    state.coefficients + s * step * change,
                    state.values | {n: state.values[n] + s * step * v for n, v in values.items()},
                ),
            )
            for s in (1, -1)
        ]
        for row, blocks, high, low in zip(rows, linear, *ends, strict=True):
            finite = (high.whitened - low.whitened) / (2 * step)
            exact = along(blocks, model, change, values)
            if np.abs(finite).max() > 1e-6:
                felt.add(what)
            # a central difference's truncation and rounding: 1e-16 of the residual over the step
            atol = 3e-6 * np.abs(finite).max() + 1e-8 * np.abs(row.whitened).max() + 1e-9
            assert_allclose(exact, finite, atol=atol, rtol=0, err_msg=f"{row.name} by {what}")
    (h,) = model.hypotheses
    own = {h.key(p.name) for p in effect.parameters} | {h.key(s.name) for s in effect.states}
    assert own <= felt  # every number of the effect is in some row


MOVING = [e for e in VARIANTS if e.name in ("mount_pose", "mount_shift", "skin_sliding", "soft_mount", "rocking_mount",
                                            "joint_play", "axis_coupling", "moving_centre")]  # fmt: skip


@pytest.mark.parametrize("effect", MOVING, ids=lambda e: f"{e.name}{e.variant}")
@pytest.mark.parametrize("rig", ["hinge", "pendulum", "free"])
def test_a_moving_sensor_reads_the_derivatives_of_its_own_pose(effect, rig):
    """Orientations and positions over time, without any rate, against what the IMU reads."""
    if not effect.fits(rig_tree(rig)):
        return
    time = np.arange(0.0, SECONDS, 0.01)
    pose = Pose("segment1", time, np.zeros((len(time), 3)), np.tile([1.0, 0, 0, 0], (len(time), 1)))
    model = model_with(effect, rig, poses=() if rig == "pendulum" else (pose,))
    state = random_state(model, np.random.default_rng(3), size=0.3)
    state.coefficients[:] *= 0.5
    if ATTITUDE in model.tracks.widths:
        state.coefficients[:, model.tracks.columns(ATTITUDE)] += [0.5, 0.0, 0.0, 0.0]
    imu = model.recording.imus[-1]

    def seen(at):
        moment = Moment(model.tracks, state.coefficients, Jet(at[:, None]))
        segment = model.segments(state, moment)[f"segment{imu.name[-1]}"]
        sensor = segment.child(model.mount(imu, state, moment, segment))
        return sensor, model.reading(imu, state, moment, segment)

    at, h = np.linspace(0.1, 0.5, 15), 1e-4
    (before, _), (now, reading), (after, _) = (seen(at + s * h) for s in (-1, 0, 1))
    turned = (Rotation.from_matrix(before.turn.matrix).inv() * Rotation.from_matrix(after.turn.matrix)).as_rotvec()
    acceleration = (after.position.value - 2 * now.position.value + before.position.value) / h**2
    force = Rotation.from_matrix(now.turn.matrix).inv().apply(acceleration - GRAVITY)
    # a small turn's rate is right to its angle's third power, 2e-3 of rates and accelerations of tens
    gyro_scale, force_scale = np.abs(reading.gyro.value).max(), np.abs(force).max()
    assert_allclose(reading.gyro.value, turned / (2 * h), atol=2e-3 * gyro_scale)
    assert_allclose(reading.accel.value, force, atol=2e-3 * force_scale)


def test_a_grid_gives_starts_and_unknown_ones_are_named():
    soft = EFFECTS["soft_mount"]
    started = [soft.starting(frequency=f) for f in soft.grid(60.0)["frequency"]]
    assert [e.parameters[0].centre.tolist() for e in started] == [
        [np.log(f)] * 3 for f in (3.0, 4.5, 6.5, 9.5, 14.0, 20.0, 30.0)
    ]
    assert soft.parameters[0].start == 10.0
    with pytest.raises(InputError, match="soft_mount: unknown parameter 'mass'; known: frequency, damping_ratio"):
        soft.starting(mass=1.0)


def test_clocks_are_compared_with_another_clock():
    offset = EFFECTS["time_offset"]
    assert offset.places(recording_of("hinge")) == ("imu1", "imu2")
    assert offset.places(recording_of("hinge", encoders=())) == ("imu2",)
    assert offset.places(recording_of("pendulum")) == ()
    assert offset.places(recording_of("hinge", base="fixed")) == ("imu2",)
    assert offset.places(recording_of("hinge", base="fixed", encoders=())) == ()
    assert EFFECTS["clock_skew"].places(recording_of("hinge", base="fixed", encoders=())) == ("imu2",)
    seen = Pose("segment1", np.arange(3.0), np.zeros((3, 3)), np.tile([1.0, 0, 0, 0], (3, 1)))
    assert offset.places(recording_of("free", base="fixed", poses=(seen,))) == ("imu1",)  # it rests on none
    assert shift(np.zeros((1, 3))).offset.value.shape == (1, 3)


def test_a_swings_rates_are_its_derivatives():
    model = model_of(recording_of("pendulum"), knots_per_s=20.0)
    state, at, h = random_state(model, np.random.default_rng(9)), np.linspace(0.1, 0.4, 9), 1e-4
    before, now, after = (
        swing(model.segments(state, Moment(model.tracks, state.coefficients, Jet((at + k * h)[:, None])))["segment1"])
        for k in (-1, 0, 1)
    )
    angles = [x[0].value for x in (before, now, after)]
    assert_allclose(now[1].value, (angles[2] - angles[0]) / (2 * h), rtol=1e-5, atol=1e-5)  # h^2 of its own
    # a second difference's truncation: h^2 / 12 of a fourth derivative of about 1 rad / (0.05 s)^4
    assert_allclose(now[2].value, (angles[2] - 2 * angles[1] + angles[0]) / h**2, rtol=1e-4, atol=3e-4)


@pytest.mark.parametrize("effect", VARIANTS, ids=lambda e: f"{e.name}{e.variant}")
def test_a_plain_simulation_takes_the_same_lines(effect):
    """Numbers in, numbers out: no stage asks for a derivative."""
    rng, n = np.random.default_rng(7), 6

    def plain(width):
        return Jet(rng.normal(size=(n, width)))

    segment = Motion(plain(3), plain(3), plain(3), rotation(0.3 * rng.normal(size=(n, 3))))
    link = Link(rotation(np.array([[0.1, 0.2, 0.3]])), offset=Jet(np.array([[0.1, 0.0, 0.0]])))
    widths = {s.name: s.width for s in effect.states}
    scene = Scene(
        plain(1), segment, plain(1), plain(1), plain(1), plain(3), plain(3),
        lambda name, _: Jet(0.01 * rng.normal(size=(n, widths[name]))), link, segment.child(link),
    )  # fmt: skip
    values = {q.name: Jet((np.exp(q.centre) if q.log else q.centre + q.std)[None]) for q in effect.parameters}
    reading = Reading(plain(3), plain(3), plain(1))
    error = effect.error(reading, values)
    moved, jointed = effect.mount(link, scene, values), effect.joint(link, scene, values)
    filtered = effect.filtered(reading, scene, values)
    out = [
        effect.clock(plain(1), values), effect.gravity(Jet(GRAVITY[None]), values), moved.turn, moved.offset_accel,
        jointed.turn, jointed.offset_accel, effect.encoder(plain(1), scene, values), filtered.gyro, filtered.accel,
        error.gyro, error.accel, effect.torque(scene, values), effect.lighter(values),
        *(law.residual for law in effect.equations(scene, values)),
    ]  # fmt: skip
    for x in out:
        assert x is None or x.blocks == {}
        assert x is None or np.isfinite(x.matrix if isinstance(x, Turn) else x.value).all()


def test_play_and_a_moving_pivot_alone_have_states_without_a_law():
    assert {effect.name for effect in VARIANTS if effect.free} == {"joint_play", "moving_pivot"}


@pytest.mark.parametrize("effect", VARIANTS, ids=lambda e: f"{e.name}{e.variant}")
def test_what_traits_name_is_there(effect):
    assert not numbers_lacking(effect)
    assert {*effect.leaves_to, *(alike.effect for alike in effect.alike)} <= set(EFFECTS)
    assert effect.phrase
    assert effect.fault is None or not effect.parameters  # raw samples show it, no fit
    assert effect.in_the_rig == effect.acts("mount", "joint", "torque", "lighter", "gravity")  # MuJoCo plays them all
