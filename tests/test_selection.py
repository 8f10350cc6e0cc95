"""Algorithms 2 and 3 of Olsson 2020: against their definitions, the printed form, qmt, and as a stream."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.hinge_rigs import random_rig
from imubench import rotations
from imubench.errors import InputError
from imubench.estimators import selection_printed
from imubench.estimators.selection import select
from imubench.estimators.selection_accel import batched, literal, penalties, pick_accel, thin
from imubench.estimators.selection_gyro import gyro_scores, pick_gyro
from imubench.estimators.selection_online import OnlineSelection
from imubench.estimators.selection_order import coherence
from imubench.estimators.selection_printed import printed

SIGNS = np.array([[(-1.0) ** (i & j).bit_count() for j in range(1, 7)] for i in range(8)])
"""(8, 6) of +-1: all directions are equally strong, and every row has c = 0.41 with each axis."""


def pieces(seed, count=400):
    """At rest, turning a little, in a plane and freely: four times `count` samples at 50 Hz with noise."""
    rng = np.random.default_rng(seed)
    parts = []
    for amplitude, planar in ((0.2, False), (1.0, True), (1.0, False)):
        rig = random_rig(rng, count, 50.0, amplitude=amplitude, planar=planar).noisy(rng, 0.005, 0.03)
        parts.append([*rig.gyro, *rig.accel])
    rest = [np.zeros((count, 3))] * 2 + [np.tile(a[0], (count, 1)) for a in parts[0][2:]]
    stds = (0.005, 0.005, 0.03, 0.03)
    parts.insert(0, [a + std * rng.normal(size=a.shape) for a, std in zip(rest, stds, strict=True)])
    return tuple(np.concatenate(kind) for kind in zip(*parts, strict=True))


def rows_of_kind(kind, m, rng):
    normal = rng.normal(size=(m, 6))
    angle = rng.uniform(0, 2 * np.pi, m)
    zero = np.zeros(m)
    return {
        "no direction preferred": normal,
        "stretched": normal * [5, 4, 3, 2, 1, 0.1],
        "planar": np.stack([np.cos(angle), np.sin(angle), zero, -np.cos(2 * angle), -np.sin(2 * angle), zero], axis=1),
        "two postures": 10 * np.eye(6)[rng.integers(0, 2, m)] + 0.1 * normal,
        "one posture": np.tile(normal[:1], (m, 1)),
        "exactly even": np.eye(6)[rng.integers(0, 6, m)],
        "nearly even": np.eye(6)[rng.integers(0, 6, m)] + 1e-9 * normal,
        "none coherent": SIGNS[rng.integers(0, 8, m)],
        "zeros among them": normal * rng.integers(0, 2, (m, 1)),
    }[kind]


KINDS = (
    "no direction preferred",
    "stretched",
    "planar",
    "two postures",
    "one posture",
    "exactly even",
    "nearly even",
    "none coherent",
    "zeros among them",
)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-20, 20), min_size=1, max_size=60), st.integers(0, 12))
def test_gyroscope_scores_are_the_smallest_difference_in_the_window(values, n):
    values = np.array(values)
    expected = []
    for k in range(values.size):
        window = values[max(0, k - n) : k + n + 1]
        expected.append(window[np.argmin(np.abs(window))])  # argmin: the earliest of equal ones
    assert np.array_equal(gyro_scores(values, n), expected)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(-5, 5), min_size=1, max_size=40), st.integers(1, 20))
def test_gyroscope_samples_come_from_both_ends_of_the_order(scores, n_max):
    kept = pick_gyro(np.array(scores, dtype=float), n_max)
    falling = sorted(range(len(scores)), key=lambda k: (-scores[k], k))
    small = n_max // 2
    expected = falling if len(scores) <= n_max else falling[: n_max - small] + falling[len(falling) - small :]
    assert kept.tolist() == sorted(expected)


def test_an_outlier_of_one_sample_is_not_selected():
    gyro1, gyro2, accel1, accel2 = (a.copy() for a in pieces(1))
    gyro1[200] = 50.0, 0.0, 0.0  # at rest
    assert 200 not in select(gyro1, gyro2, accel1, accel2, 100).gyro
    assert 200 in select(gyro1, gyro2, accel1, accel2, 100, half_width=0).gyro


@pytest.mark.parametrize("n", [0, 1, 10])
def test_penalties_are_the_smaller_mean_energy_of_the_window(n):
    gyro1, gyro2, *_ = pieces(2, 30)
    expected = np.full(len(gyro1), np.inf)
    for k in range(n, len(gyro1) - n):
        window = slice(k - n, k + n + 1)
        expected[k] = min(np.mean(np.sum(g[window] ** 2, axis=1)) for g in (gyro1, gyro2))
    np.testing.assert_allclose(penalties(gyro1, gyro2, n), expected, rtol=1e-13)  # rounding of 21 terms


def test_a_record_shorter_than_its_window_has_no_slow_sample():
    short = [a[:15] for a in pieces(3)]
    assert select(*short, 5).accel.size == 0
    assert select(*short, 15).accel.tolist() == list(range(15))  # nothing to remove, so nothing is


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(KINDS), st.integers(1, 150), st.integers(1, 60), st.booleans(), st.integers(0, 2**32 - 1))
def test_the_gram_form_keeps_what_the_printed_form_keeps(kind, m, n_max, ties, seed):
    rng = np.random.default_rng(seed)
    rows = rows_of_kind(kind, m, rng)
    penalty = rng.integers(0, 4, m).astype(float) if ties else rng.uniform(size=m)
    assert np.array_equal(printed(rows, penalty, n_max), literal(rows, penalty, n_max))


@pytest.mark.parametrize("front", [8, 512])
@pytest.mark.parametrize("kind", [k for k in KINDS if k != "exactly even"])
def test_the_gram_form_keeps_what_the_printed_form_keeps_of_many(kind, front, monkeypatch):
    """With rows held ready that suffice, and with so few that they run out again and again."""
    monkeypatch.setattr(selection_printed, "FRONT", front)
    rng = np.random.default_rng(7)
    rows, penalty = rows_of_kind(kind, 1500, rng), rng.uniform(size=1500)
    assert np.array_equal(printed(rows, penalty, 100), literal(rows, penalty, 100))


def test_on_motion_the_gram_form_is_the_printed_form_without_one_decomposition(monkeypatch):
    arrays = pieces(4, 900)
    expected = select(*arrays, 300, form="literal")
    monkeypatch.setattr(selection_printed, "choose", lambda *_: pytest.fail("a choice was left open"))
    found = select(*arrays, 300)
    assert np.array_equal(found.accel, expected.accel)
    assert np.array_equal(found.accel1, arrays[2][found.accel])
    assert np.array_equal(found.accel2, arrays[3][found.accel])


def test_rounding_is_bounded_from_above():
    """The bound on the turn of w1 must hold against w1 of the rows themselves, after many down-dates."""
    rng = np.random.default_rng(5)
    rows = rng.normal(size=(4000, 6)) * [1.0, 1.001, 0.9, 0.5, 0.1, 0.1]
    left = selection_printed._Left(rows, np.arange(4000))
    for place in range(1900):  # no fresh sum before half have gone
        left.remove_one(place)
    values, vectors = np.linalg.eigh(left.gram)
    exact = np.linalg.svd(rows[1900:], full_matrices=False)[2][0]
    turn = np.linalg.norm(exact - vectors[:, 5] * np.sign(exact @ vectors[:, 5]))
    assert 0 < turn < left.rounding / (values[5] - values[4])


@pytest.mark.parametrize("form", ["printed", "literal", "batched"])
def test_where_no_row_is_coherent_the_largest_penalty_goes(form):
    rows = SIGNS * [1.01, 1.0, 1.0, 1.0, 1.0, 1.0]
    assert coherence(rows, np.eye(6)[0]).max() < 0.5
    penalty = np.array([3.0, 1.0, 4.0, 1.5, 9.0, 2.0, 6.0, 5.0])
    assert thin(rows, penalty, 7, form).tolist() == [0, 1, 2, 3, 5, 6, 7]


@pytest.mark.parametrize("form", ["printed", "literal", "batched"])
def test_a_lone_direction_is_kept_and_the_faster_of_the_many_go(form):
    rows = np.tile(np.eye(6)[0], (20, 1))
    rows[3] = np.eye(6)[1]
    penalty = np.arange(20.0)
    penalty[3] = 100.0
    assert thin(rows, penalty, 5, form).tolist() == [0, 1, 2, 3, 4]


def test_batches_go_by_the_ratio_of_the_singular_values():
    """Worked by hand: s1 = 3 and s2 = 2, so floor(2/3 x 13) + 1 = 9 would go; 4 is the excess, along the first axis."""
    rows = np.eye(6)[[0] * 9 + [1] * 4]
    penalty = np.arange(13.0)
    assert batched(rows, penalty, 9).tolist() == [0, 1, 2, 3, 4, 9, 10, 11, 12]
    # One at a time, the axes take turns once they are even: 9 to 4 rows, then 4 to 4, of 13.
    assert np.bincount(rows[printed(rows, penalty, 6)].argmax(axis=1)).tolist() == [3, 3]
    # In batches of floor(2/3 13) + 1 = 9, but 7 are the excess, all seven come from the first axis.
    assert np.bincount(rows[batched(rows, penalty, 6)].argmax(axis=1)).tolist() == [2, 4]


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_batches_are_those_of_the_authors_code(seed):
    pytest.importorskip("qmt")
    from benchmarks.selection import N_MAX, qmt_selection

    # At rest at the ends, where their gyroscope scores are 0 and ours those of a shorter window.
    arrays = tuple(np.concatenate([a, a[:50]]) for a in pieces(seed, 800))
    peer, ours = qmt_selection(*arrays), select(*arrays, N_MAX, form="batched")
    assert np.array_equal(ours.accel, peer.accel)
    assert np.array_equal(ours.gyro, peer.gyro)


@pytest.mark.parametrize("form", ["printed", "batched"])
@pytest.mark.parametrize("seed", range(5))
def test_turning_the_sensors_in_their_sockets_changes_no_set(form, seed):
    gyro1, gyro2, accel1, accel2 = pieces(seed)
    turn1, turn2 = rotations.random(np.random.default_rng(seed), 2)
    turned = [rotations.rotate(turn1, gyro1), rotations.rotate(turn2, gyro2)]
    turned += [rotations.rotate(turn1, accel1), rotations.rotate(turn2, accel2)]
    before, after = select(gyro1, gyro2, accel1, accel2, 150, form=form), select(*turned, 150, form=form)
    assert np.array_equal(before.gyro, after.gyro)
    assert np.array_equal(before.accel, after.accel)


def test_few_samples_are_all_kept_and_fast_ones_only_go_from_many():
    arrays = pieces(6, 100)
    assert select(*arrays, 400).accel.size == 400
    many = select(*arrays, 399)
    assert (penalties(*arrays[:2])[many.accel] <= 1.0).all()
    assert many.accel.size < 399


def batches(arrays, sizes):
    at = 0
    for size in sizes:
        yield at + size, tuple(a[at : at + size] for a in arrays)
        at += size


def cut(total, rng):
    """Batches of 0 to 120 samples, most often 1 second."""
    sizes = []
    while sum(sizes) < total:
        sizes.append(int(min(rng.choice([0, 1, 7, 50, 50, 50, 120]), total - sum(sizes))))
    return sizes


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 500), st.integers(0, 12))
def test_a_stream_that_remembers_all_selects_what_the_batch_selects(seed, n_max, n):
    rng = np.random.default_rng(seed)
    arrays = pieces(seed, 150)
    stream = OnlineSelection(n_max, n, memory="all")
    for end, new in batches(arrays, cut(600, rng)):
        online, batch = stream.update(*new), select(*(a[:end] for a in arrays), n_max, n)
        for name in ("gyro", "accel", "gyro1", "gyro2", "accel1", "accel2"):
            assert np.array_equal(getattr(online, name), getattr(batch, name)), name


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 500))
def test_a_stream_of_survivors_chooses_from_what_it_kept_and_what_came(seed, n_max):
    """Algorithm 2 as in the batch; Algorithm 3 as in the batch until its first removal, then from survivors."""
    rng = np.random.default_rng(seed)
    arrays = pieces(seed, 150)
    rows, penalty = np.hstack([arrays[2], -arrays[3]]), penalties(*arrays[:2])
    stream, kept, scored = OnlineSelection(n_max), np.empty(0, dtype=int), 0
    for end, new in batches(arrays, cut(600, rng)):
        online, batch = stream.update(*new), select(*(a[:end] for a in arrays), n_max)
        assert np.array_equal(online.gyro, batch.gyro)
        complete = max(0, end - 10)
        offered = np.concatenate([kept, np.arange(scored, complete)])
        scored = complete
        if end <= n_max:
            kept = offered
            assert np.array_equal(online.accel, batch.accel)
            continue
        slow = offered[penalty[offered] <= 1.0]
        kept = slow[thin(rows[slow], penalty[slow], n_max)]
        assert np.array_equal(online.accel, kept)
        if np.count_nonzero(penalty[:complete] <= 1.0) <= n_max:
            assert np.array_equal(online.accel, batch.accel)


def test_survivors_are_bounded_and_differ_from_the_batch():
    arrays = pieces(8, 900)
    stream = OnlineSelection(200)
    for _, new in batches(arrays, [50] * 72):
        online = stream.update(*new)
        assert len(stream._gyro.ids) <= 200 and len(stream._accel.ids) <= 200 and len(stream._last) <= 20
    batch = select(*arrays, 200)
    shared = np.intersect1d(online.accel, batch.accel).size
    assert online.accel.size == batch.accel.size == 200
    assert 0 < shared < 200


def test_a_bad_batch_leaves_the_stream_as_it_was():
    arrays = pieces(9, 100)
    stream, other = OnlineSelection(100), OnlineSelection(100)
    first, second = (tuple(a[s] for a in arrays) for s in (slice(0, 200), slice(200, 400)))
    for one in (stream, other):
        one.update(*first)
    with pytest.raises(InputError, match=r"^accel2: expected 200 samples as in gyro1, got 199$"):
        stream.update(*second[:3], second[3][1:])
    one, two = stream.update(*second), other.update(*second)
    assert np.array_equal(one.gyro, two.gyro) and np.array_equal(one.accel, two.accel)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"n_max": 0}, r"n_max: expected at least 1 sample, got 0"),
        ({"half_width": -1}, r"half_width: expected 0 or more samples, got -1"),
        ({"threshold": np.inf}, r"threshold: expected a finite energy of 0 or more rad\^2/s\^2, got inf"),
        ({"form": "fast"}, r"unknown form of Algorithm 3 'fast'; known: printed, literal, batched"),
        ({"gyro2": np.zeros((400, 2))}, r"gyro2: expected shape \(n, 3\), got \(400, 2\)"),
        ({"accel1": np.full((400, 3), np.nan)}, r"accel1: expected finite numbers, got .* in row 0"),
        ({"accel2": np.zeros((3, 3))}, r"accel2: expected 400 samples as in gyro1, got 3"),
    ],
)
def test_bad_input_is_named(change, message):
    good = dict(zip(("gyro1", "gyro2", "accel1", "accel2"), pieces(0, 100), strict=True)) | {"n_max": 10}
    with pytest.raises(InputError, match=f"^{message}"):
        select(**(good | change))


def test_unknown_names_are_listed():
    with pytest.raises(InputError, match=r"^unknown memory 'some'; known: survivors, all$"):
        OnlineSelection(10, memory="some")
    with pytest.raises(InputError, match=r"^unknown form of Algorithm 3 'x'; known: printed, literal, batched$"):
        pick_accel(np.eye(6), np.zeros(6), 3, form="x")
