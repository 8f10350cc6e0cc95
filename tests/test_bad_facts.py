"""A declared fact that cannot be ends with one line: which key, what was expected and what came."""

import pytest

from imubench.format1 import read
from tests.damage import refused, set_cell, swap


def test_non_utf8_in_toml(good):
    content = (good / "recording.toml").read_bytes().replace(b'"good"', b'"G\xfcte"')
    (good / "recording.toml").write_bytes(content)
    refused(good, "recording.toml, line 2: expected UTF-8 text, got byte 0xfc")


@pytest.mark.parametrize("slip", ["rate 100", 'name = "imu1', "[[imu]", "x = " + "9" * 5000])
def test_toml_syntax(good, slip):
    with (good / "recording.toml").open("a") as file:
        file.write(f"\n{slip}\n")
    refused(good, "rec/recording.toml: expected TOML, got: ")


@pytest.mark.parametrize("deep", ["x = " + "[" * 5000, "x = " + "[" * 50 + "]" * 50, ".".join("x" * 50) + " = 1"])
def test_toml_too_deep(good, deep):
    with (good / "recording.toml").open("a") as file:
        file.write(f"\n{deep}\n")
    refused(good, "rec/recording.toml: expected tables and lists at most 32 deep, got deeper ones")


def test_toml_syntax_names_the_line(good):
    swap(good, "recording.toml", 'rig = "hinge"', "rig = hinge")
    refused(good, "expected TOML, got: Invalid value (at line 3, column 7)")


@pytest.mark.parametrize(("version", "got"), [("2", "2"), ('"1"', "text '1'"), ("true", "true"), ("1.0", "1.0")])
def test_another_format(good, version, got):
    swap(good, "recording.toml", "format = 1", f"format = {version}")
    refused(good, f"recording.toml, key 'format': expected 1, got {got}")


@pytest.mark.parametrize(
    ("line", "where", "key"),
    [
        ('format = 1\n', "recording.toml, key 'format': expected an integer", "format"),
        ('rig = "hinge"\n', "recording.toml, key 'rig': expected a text", "rig"),
        ('file = "imu2.csv"\n', "[[imu]] number 2, key 'file': expected a text", "file"),
        ('joint = "hinge"\n', "[[encoder]] number 1, key 'joint': expected a text", "joint"),
        ("mass = 1.2\n", "[body], key 'mass': expected a number in kg", "mass"),
        ("end = 5.0\n", "[[free_swing]] number 1, key 'end': expected a number in s", "end"),
        ('file = "reference.csv"\n', "[reference], key 'file': expected a text", "file"),
    ],
)  # fmt: skip
def test_missing_key(good, line, where, key):
    swap(good, "recording.toml", line, "")
    refused(good, where, "got no such key")


@pytest.mark.parametrize(
    ("before", "added", "message"),
    [
        (
            "rig = ",
            "grav = 9.81",
            "recording.toml, unknown key 'grav'; known: format, name, rig, motion, gravity, base",
        ),
        ("rig = ", "[[gyro]]\n[x]\n", "unknown key 'gyro'; known: format, name"),
        ("mass = ", "unit = 'kg'", "[body], unknown key 'unit'; known: mass, com, inertia"),
        ('joint = "hinge"', "gyro_unit = 'deg/s'", "[[encoder]] number 1, unknown key 'gyro_unit'; known: joint, file"),
        (
            "gyro_range",
            "gyr_range = 1",
            "[[imu]] number 1, unknown key 'gyr_range'; known: name, file, rate, gyro_noise",
        ),
        ("segment = ", "joint = 'x'", "[[pose]] number 1, unknown key 'joint'; known: segment, file"),
        ("start = ", "stop = 1", "[[free_swing]] number 1, unknown key 'stop'; known: start, end"),
        ('file = "reference.csv"', "path = 'x'", "[reference], unknown key 'path'; known: file"),
    ],
)
def test_unknown_key(good, before, added, message):
    swap(good, "recording.toml", before, f"{added}\n{before}")
    if added.startswith("[["):  # keys below would belong to the new table: put it at the end instead
        swap(good, "recording.toml", f"{added}\n{before}", before)
        (good / "recording.toml").write_text((good / "recording.toml").read_text() + f"\n{added}")
    refused(good, message)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "good"', "name = 3", "recording.toml, key 'name': expected a text, got 3"),
        ('name = "good"', "name = 2026-01-01", "key 'name': expected a text, got a date or time 2026-01-01"),
        ("mass = 1.2", "mass = '1.2 kg'", "[body], key 'mass': expected a number in kg, got text '1.2 kg'"),
        ("mass = 1.2", "mass = true", "[body], key 'mass': expected a number in kg, got true"),
        ("gyro_range = 35.0", "gyro_range = [35]", "key 'gyro_range': expected a number in rad/s, got list [35]"),
        ("gyro_range = 35.0", "gyro_range = nan", "key 'imu[0].gyro_range': expected a finite number, got nan"),
        ("gyro_range = 35.0", "gyro_range = -35", "imu1.gyro_range: expected a number > 0, got -35.0"),
        ("gyro_range = 35.0", "gyro_noise_std = -1", "key 'gyro_noise_std': expected a finite number >= 0, got -1"),
        ("gyro_range = 35.0", "mount_position = [0, 1]", "expected a list of 3 numbers in m, got list [0, 1]"),
        (
            "gyro_range = 35.0",
            "mount_position = [0, 1, '2']",
            "expected a list of 3 numbers in m, got list [0, 1, '2']",
        ),
        (
            "gyro_range = 35.0",
            "mount_position = 0.1",
            "key 'mount_position': expected a list of 3 numbers in m, got 0.1",
        ),
        ("gyro_range = 35.0", "mount_quaternion = [1, 0, 0]", "expected a list of 4 numbers in order w, x, y, z, got"),
        (
            "mass = 1.2",
            f"mass = {'9' * 400}",
            "key 'body.mass': expected a whole number of 64 bits, got one of 1,329 bits",
        ),
        ("mass = 1.2", "mass = 0", "recording.toml: body.mass: expected a number > 0, got 0.0"),
        ("[body]", "[[body]]", "key 'body': expected one table [body], got list [{"),
        ("[[encoder]]", "[encoder]", "key 'encoder': expected tables [[encoder]], got a table"),
    ],
)
def test_wrong_type_or_value(good, old, new, message):
    swap(good, "recording.toml", old, new)
    refused(good, message)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('rig = "hinge"', 'rig = "pendulm"', "key 'rig': unknown rig 'pendulm'; known: hinge, pendulum, free"),
        ('rig = "hinge"', 'rig = "arm.xml"', "key 'rig': expected an MJCF file beside it, got no file 'arm.xml'"),
        ('rig = "hinge"', 'rig = "/a.xml"', "key 'rig': expected a file below the recording's folder, got '/a.xml'"),
        ('rig = "hinge"', 'rig = "hinge"\nmotion = "fast"', "unknown motion 'fast'; known: hand, free"),
        ('rig = "hinge"', 'rig = "hinge"\nbase = "loose"', "unknown base 'loose'; known: free, fixed"),
        ('rig = "hinge"', 'rig = "hinge"\ngravity = -9.81', "gravity: expected a number >= 0, got -9.81"),
        ('name = "imu2"', 'name = "imu3"', "unknown imu on rig hinge 'imu3'; known: imu1, imu2"),
        ('name = "imu2"', 'name = "imu1"', "expected each imu once, got imu1, imu1"),
        ('joint = "hinge"', 'joint = "knee"', "[[encoder]] number 1: unknown joint of rig hinge 'knee'; known: hinge"),
        ('"segment1"', '"thigh"', "[[pose]] number 1: unknown segment of rig hinge 'thigh'; known: segment1, segment2"),
    ],
)
def test_unknown_name(good, old, new, message):
    swap(good, "recording.toml", old, new)
    refused(good, "rec/recording.toml", message)


def test_quaternions_that_are_no_units(good):
    swap(good, "recording.toml", "gyro_range = 35.0", "mount_quaternion = [1, 0, 0.2, 0]")
    message = "imu1.mount_quaternion: expected a unit quaternion w, x, y, z, got [1.0, 0.0, 0.2, 0.0] of norm 1.02"
    refused(good, f"rec/recording.toml: {message}")
    swap(good, "recording.toml", "mount_quaternion = [1, 0, 0.2, 0]", "")
    swap(good, "recording.toml", 'rig = "hinge"', 'rig = "hinge"\nbase_quaternion = [0, 0, 0, 0]')
    refused(good, "base_quaternion: expected a unit quaternion")


@pytest.mark.parametrize(("file", "first"), [("reference.csv", "q1_w"), ("pose1.csv", "qw")])
def test_a_measured_quaternion_that_is_no_unit(good, file, first):
    set_cell(good, file, 20, first, "0.98")
    refused(good, f"rec/{file}, line 20, columns {first} to ", "got [0.98, 0.0, 0.0, 0.0] of norm 0.98")
    set_cell(good, file, 20, first, "0.995")  # three digits are enough
    read(good)
    set_cell(good, file, 20, first, "")
    read(good)


def test_nothing_measured(good):
    text = (good / "recording.toml").read_text().split("[[")[0]
    (good / "recording.toml").write_text(text)
    refused(good, "recording.toml: good: expected at least one imu, encoder or pose, got none")
