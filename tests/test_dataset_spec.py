"""A spec is checked when it is read: one line that says what, where, expected and got; exit code 2."""

import numpy as np
import pytest

from imubench.dataset.spec import load_spec, parse_spec
from imubench.errors import InputError
from imubench.main import main

RIG = "[[rig]]\nfamily = 'hinge'\n"


def parsed(text: str):
    return parse_spec({"spec.toml": text.encode()})


def test_a_family_is_enough():
    spec = parsed(RIG)
    assert (spec.rate, spec.seconds.low, spec.sensors) == (100.0, 60.0, 2)
    assert [m.kind for m in spec.motions] == ["random"]
    assert spec.imus[0].profile.name == "xsens_mtw"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"expected one \[\[rig\]\] or more, got none"),
        ("rig = 3", r"rig: expected \[\[rig\]\] tables, got 3"),
        ("[[rig", "expected TOML"),
        ("lenght = 3\n" + RIG, "unknown key in spec.toml 'lenght'; known: format, name"),
        ("format = 2\n" + RIG, "format: expected 1, got 2"),
        ("seconds = [20, 10]\n" + RIG, "seconds: expected a range from low to high, got 20 to 10"),
        ("seconds = 'long'\n" + RIG, r"seconds: expected a number, \[low, high\]"),
        ("seconds = 1e9\n" + RIG, "expected at most 2,000,000 samples"),
        ("rate = 0\n" + RIG, "rate: expected numbers >= 1"),
        ("recordings_per_rig = 0\n" + RIG, "recordings_per_rig: expected a whole number of 1 or more, got 0"),
        ("precision = 'half'\n" + RIG, "precision 'half'; known: single, double"),
        ("splits = { train = 0.5 }\n" + RIG, "splits: expected fractions that make 1, got 0.5"),
        ("[[rig]]\nfamily = 'knee'", r"rig\[0\].family 'knee'; known: hinge, pendulum, free"),
        (RIG + "segment_mass = [-1, 2]", r"rig\[0\].segment_mass: expected numbers > 0, got \[-1, 2\]"),
        (RIG + "segment_mass = { std = 1 }", r"rig\[0\].segment_mass: expected numbers > 0"),
        (RIG + "mount_distance = [0.5, 0.6]", r"mounts that a segment of at most 0.4 m can hold, got 0.5 m"),
        (RIG + "base = 'loose'", r"rig\[0\].base 'loose'; known: free, fixed"),
        ("[[rig]]\nfamily = 'free'\nbase = 'fixed'", "expected a hinge for base = 'fixed', got free"),
        (RIG + "soft = { frequency = [1, 900] }", r"rig\[0\].soft.frequency: expected numbers <= 200, got"),
        (RIG + "rocking = { com = [-0.02, 0.02] }", r"rig\[0\].rocking.com: expected numbers >= -0.006 and <= 0.006"),
        (RIG + "soft_probability = 1.5", r"soft_probability: expected numbers >= 0 and <= 1, got 1.5"),
        (RIG + "[[motion]]\nkind = 'dance'", r"motion\[0\].kind 'dance'; known: random, olsson2020, pendulum, file"),
        ("imu = []\n" + RIG, r"expected one \[\[imu\]\] or more, got none"),
        ("motion = []\n" + RIG, r"expected one \[\[motion\]\] or more, got none"),
        (RIG + "[[motion]]\nkind = ['random']", r"motion\[0\].kind '\['random'\]'; known: random"),
        (RIG + "[[motion]]\nkind = 'pendulum'", r"rig\[0\]: expected a motion that a free hinge can do, got pendulum"),
        (RIG + "[[motion]]\nkind = 'olsson2020'\nnumbers = [15]", "unknown motion in .*numbers '15'; known: 1, 2"),
        ("seconds = 5\n" + RIG + "[[motion]]\nkind = 'olsson2020'", "expected 10 s or more for olsson2020 motions"),
        (RIG + "[[motion]]\nkind = 'file'\npath = 'gone.csv'", r"expected the file 'gone.csv', got none"),
        (RIG + "[[imu]]\nprofile = 'watch'", r"imu\[0\].profile 'watch'; known: perfect, xsens_mtw"),
        (RIG + "[[effect]]\nname = 'ghost'", r"effect\[0\].name 'ghost'; known: gyro_bias"),
        (RIG + "[[effect]]\nname = 'joint_play'", r"effect\[0\].range: expected a number or a range, got none"),
        (RIG + "[[effect]]\nname = 'gyro_bias'\nat = 'imu3'", r"effect\[0\].at 'imu3'; known: imu1, imu2"),
        (
            RIG + "[[effect]]\nname = 'gyro_bias'\nbiass = 1",
            "unknown key in .*'biass'; known: name, at, probability, bias",
        ),
        (RIG + "[[effect]]\nname = 'dropouts'", r"effect\[0\].fraction: expected a number or a range, got none"),
        (RIG + "[[effect]]\nname = 'saturation'\nlimit = 1", r"channels: expected \['gyro'\] or \['accel'\], got None"),
        (RIG + "[[effect]]\nname = 'gyro_bias'\n" * 2, "effect: expected gyro_bias imu1 once, got it twice"),
        (
            RIG + "soft = {}\n[[effect]]\nname = 'soft_mount'",
            "soft_mount: expected springs with the rig or as an effect",
        ),
    ],
)
def test_a_wrong_spec_is_said_in_one_line(text, message):
    with pytest.raises(InputError, match=message) as caught:
        parsed(text)
    assert "\n" not in str(caught.value)


def test_the_command_line_says_it_too_and_writes_nothing(tmp_path, monkeypatch, capsys):
    spec = tmp_path / "spec.toml"
    spec.write_text(RIG + "mount_distance = 0.5")
    monkeypatch.setattr("sys.argv", ["imubench", "generate", str(spec), "--count", "3", "--out", str(tmp_path / "out")])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 2
    assert "can hold, got 0.5 m" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def written(folder, rows=800, **columns):
    time = np.arange(rows) / 100
    columns = {"time": time, "angle": np.sin(time), **columns}
    lines = [",".join(columns), *(",".join(f"{v:.12g}" for v in row) for row in zip(*columns.values(), strict=True))]
    (folder / "mine.csv").write_text("\n".join(lines))
    (folder / "spec.toml").write_text("seconds = 5\n" + RIG + "[[motion]]\nkind = 'file'\npath = 'mine.csv'")
    return folder / "spec.toml"


def test_a_motion_of_ones_own_is_played_and_kept_with_the_spec(tmp_path):
    spec = load_spec(written(tmp_path))
    name, motion = spec.motions[0].draw(np.random.default_rng(0), 5.0)
    angle, rate = motion(np.array([1.0, 2.0])).angle, motion(np.array([1.0, 2.0])).angle_rate
    assert name == "file mine.csv"
    assert np.allclose(angle**2 + rate**2, 1.0, atol=1e-8)  # sin and cos; a quintic spline errs by about h^5
    again = parse_spec(spec.content)
    assert again.motions[0].file.duration == pytest.approx(7.99)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rows": 200}, "mine.csv: expected 5.5 s or more for recordings of 5 s, got 1.99 s"),
        ({"speed": np.zeros(800)}, "mine.csv: unknown column 'speed'; known: time, heading"),
        ({"x": np.full(800, np.nan)}, "mine.csv: x: expected finite numbers, got nan in row 0"),
        ({"time": np.zeros(800)}, "mine.csv, line 3, column 'time': expected increasing time, got a repeated stamp"),
    ],
)
def test_a_wrong_motion_is_said_in_one_line(tmp_path, changes, message):
    with pytest.raises(InputError, match=message):
        load_spec(written(tmp_path, **changes))


def test_files_stay_beside_the_spec(tmp_path):
    (tmp_path / "spec.toml").write_text(RIG + "[[motion]]\nkind = 'file'\npath = '../../etc/passwd'")
    with pytest.raises(InputError, match="expected a file beside the spec or below it"):
        load_spec(tmp_path / "spec.toml")


def test_profiles_of_ones_own(tmp_path):
    (tmp_path / "imus.toml").write_text(
        '[mine]\nrate = { value = 200, unit = "Hz", source = "measured" }\n'
        '[mine.gyro]\nnoise_std = { value = 0.3, unit = "rad/s", source = "measured" }\n'
    )
    (tmp_path / "spec.toml").write_text(RIG + "[[imu]]\nfile = 'imus.toml'\nprofile = 'mine'")
    assert load_spec(tmp_path / "spec.toml").imus[0].profile.gyro.noise_std == 0.3
