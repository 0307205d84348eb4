"""Every codec gives back every tile bit by bit, uses exactly the bits it says, and compresses what it should."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from archsim.codec.bits import get, get_signed, put
from archsim.codec.codec import (
    NUM_WORDS,
    ONLY_4X4,
    Codec,
    decode,
    encode,
    make_codec,
    one_plane_bits,
    stored_bits,
    tile_bits,
)
from archsim.codec.lloyd import FirstRow, LastDelta
from archsim.codec.planes import Steps
from archsim.errors import ArchsimError

from .tiles import FARTHEST, curved, plane_tile, planes, tiles, two_planes

SPECS = [
    *(make_codec(codec, side) for codec in Codec for side in (4, 8) if not (side == 8 and codec in ONLY_4X4)),
    make_codec(Codec.LLOYD, first_row=FirstRow.FAR),
    make_codec(Codec.LLOYD, last_delta=LastDelta.ROW_2),
    make_codec(Codec.LLOYD, first_row=FirstRow.FAR, last_delta=LastDelta.ROW_2),
]
ONE = {codec: make_codec(codec) for codec in Codec}


def bits_of(spec, tile):
    """Encode, check that decoding gives the tile and that no bit beyond those counted matters; the bits used."""
    words = np.zeros(NUM_WORDS, np.int64)
    used = encode(spec, tile, words)
    if used:
        for i in range(NUM_WORDS):  # what lies beyond the used bits is noise to the decoder
            keep = max(0, min(32, used - 32 * i))
            words[i] = (words[i] & ((1 << keep) - 1)) | (0xA5A5A5A5 & ~((1 << keep) - 1))
        back = np.full(len(tile), -1, np.int64)
        decode(spec, words, used, tile.min(), tile.max(), back)
        assert np.array_equal(back, tile)
    return used


@pytest.mark.parametrize(
    "spec", SPECS, ids=lambda s: f"{Codec(s.codec).name}-{s.side}-{s.first_row}{s.last_delta}"
)
@settings(max_examples=150, deadline=None)
@given(st.data())
def test_every_codec_is_lossless_on_every_tile(spec, data):
    tile = data.draw(tiles(spec.side))

    used = bits_of(spec, tile)

    assert stored_bits(spec, used) <= 24 * spec.side**2


@pytest.mark.parametrize(
    ("codec", "side", "bits"),
    [
        (Codec.LLOYD, 4, 127),
        (Codec.ANCHOR, 4, 119),
        (Codec.DDPCM, 4, 100),
        (Codec.DDPCM, 8, 196),
        (Codec.DDPCM_TWO_PLANES, 4, 100),
        (Codec.PLANE, 4, 120),
        (Codec.PLANE, 8, 120),
        (Codec.HASSELGREN, 4, 89),
        (Codec.HASSELGREN, 8, 137),
        (Codec.DEPTH_OFFSET, 4, 128),
    ],
)
def test_bits_of_a_plane_by_hand(codec, side, bits):
    assert bits_of(make_codec(codec, side), plane_tile(side, 1e6, 7.3, -21.8)) == bits


@pytest.mark.parametrize(
    ("steps", "side", "bits"), [("HASSELGREN", 4, 175), ("HASSELGREN", 8, 243), ("DDPCM", 4, 181)]
)
def test_bits_of_two_planes_by_hand(steps, side, bits):
    """2 x (24 + 50), a bit for the corners, side counts, and 1 or 2 bits for each sample that is no corner or
    neighbour.
    """
    row, column = np.mgrid[:side, :side]
    one, other = plane_tile(side, 1e6, 7.3, -21.8), plane_tile(side, 9e6, 100.6, 1.1)
    tile = np.where((row + column < side - 1).ravel(), one, other)

    assert bits_of(make_codec(Codec[f"{steps}_TWO_PLANES"], side), tile) == bits
    assert bits_of(make_codec(Codec[steps], side), tile) == 0


@settings(max_examples=300, deadline=None)
@given(planes(4))
def test_planes_inside_the_range_compress(tile):
    """Rounded planes that are not clamped: every planar codec takes them if its slope fields do."""
    if tile.min() == 0 or tile.max() == FARTHEST:
        return
    steep = max(
        abs(np.diff(tile.reshape(4, 4), axis=0)).max(), abs(np.diff(tile.reshape(4, 4), axis=1)).max()
    )

    assert bits_of(ONE[Codec.HASSELGREN], tile) == one_plane_bits(4, Steps.HASSELGREN)
    assert bits_of(ONE[Codec.DDPCM], tile) == one_plane_bits(4, Steps.DDPCM)
    if steep < 2**14 - 2:
        assert bits_of(ONE[Codec.ANCHOR], tile) == 119
        assert bits_of(ONE[Codec.LLOYD], tile) == 127


@settings(max_examples=200, deadline=None)
@given(st.floats(2e5, 1e7), st.floats(-2e4, 2e4), st.floats(-2e4, 2e4))
def test_plane_constants_are_found_where_rounding_leaves_them_room(base, dx, dy):
    row, column = np.mgrid[:4, :4]
    room = np.abs((base + dx * column + dy * row) % 1 - 0.5).min()
    if room < 0.002:
        return

    assert bits_of(ONE[Codec.PLANE], plane_tile(4, base, dx, dy)) == 120


@settings(max_examples=200, deadline=None)
@given(curved(4))
def test_the_papers_scheme_takes_curvature_that_defeats_the_others(tile):
    """Linear in x, second order in y, away from the limits of the range and of the fields."""
    image = tile.reshape(4, 4)
    bend = np.abs(np.diff(image, 2, axis=0)).max()
    small = max(abs(np.diff(image, axis=0)).max(), abs(np.diff(image, axis=1)).max()) < 2**14
    if tile.min() == 0 or tile.max() == FARTHEST or not small or bend < 8:
        return

    assert bits_of(ONE[Codec.LLOYD], tile) == 127
    for codec in (Codec.DDPCM, Codec.PLANE, Codec.HASSELGREN):
        assert bits_of(ONE[codec], tile) == 0


@settings(max_examples=100, deadline=None)
@given(two_planes(4))
def test_two_planes_never_do_worse_than_one(tile):
    for codec in (Codec.DDPCM, Codec.HASSELGREN):
        if bits_of(ONE[codec], tile):
            assert bits_of(ONE[Codec(codec + 1)], tile) == bits_of(ONE[codec], tile)


def test_depth_offset_takes_the_narrowest_width():
    near_far = np.array([5, FARTHEST] * 8)
    for span, width in ((7, 4), (8, 8), (127, 8), (128, 12), (2047, 12)):
        near_far[2] = 5 + span
        assert bits_of(ONE[Codec.DEPTH_OFFSET], near_far) == 16 * width
    near_far[2] = 5 + 2048
    assert bits_of(ONE[Codec.DEPTH_OFFSET], near_far) == 0


def test_the_two_readings_of_the_last_delta_differ():
    """Row slopes 0, 0, 400, 400 across: from the anchor 400 overflows row 3's nine bits, from row 2 it is
    nothing.
    """
    row, column = np.mgrid[:4, :4]
    tile = (10000 + column * np.array([0, 0, 400, 400])[:, None] + 0 * row).ravel()

    assert bits_of(make_codec(Codec.LLOYD, last_delta=LastDelta.ANCHOR), tile) == 0
    assert bits_of(make_codec(Codec.LLOYD, last_delta=LastDelta.ROW_2), tile) == 127


def test_the_two_readings_of_the_first_row_mirror_each_other():
    tile = plane_tile(4, 1e6, 100, 3) + np.repeat([0, 0, 0, 30], 4) * np.tile(np.arange(4), 4)

    assert bits_of(make_codec(Codec.LLOYD, first_row=FirstRow.NEAR), tile) == 127
    assert bits_of(make_codec(Codec.LLOYD, first_row=FirstRow.FAR), tile) == bits_of(
        make_codec(Codec.LLOYD), tile.reshape(4, 4)[::-1].ravel()
    )


@pytest.mark.parametrize(
    ("used", "stored"), [(0, 384), (1, 64), (127, 128), (128, 128), (181, 192), (384, 384)]
)
def test_memory_holds_whole_units(used, stored):
    assert stored_bits(ONE[Codec.LLOYD], used) == stored


def test_a_buffer_is_measured_tile_by_tile():
    depth = np.full((8, 8), FARTHEST, np.int32)
    depth[:4, :4] = plane_tile(4, 5000, 1, 2).reshape(4, 4)
    depth[4:, 4:] = np.random.default_rng(0).integers(0, FARTHEST, (4, 4))
    wanted = np.array([[True, False], [False, True]])

    assert np.array_equal(tile_bits(ONE[Codec.LLOYD], depth, wanted), [[128, 0], [0, 384]])


@given(st.lists(st.tuples(st.integers(1, 40), st.integers(0, 2**40 - 1)), max_size=12))
def test_fields_come_back(fields):
    words = np.zeros(NUM_WORDS, np.int64)
    at = 0
    for width, value in fields:
        at = put(words, at, value, width)
    at = 0
    for width, value in fields:
        expected = value & ((1 << width) - 1)
        assert get(words, at, width) == expected
        assert get_signed(words, at, width) == (
            expected - (1 << width) if expected >> (width - 1) else expected
        )
        at += width


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        ((Codec.LLOYD, 8), "lloyd is not defined for tiles of 8 x 8"),
        ((Codec.DDPCM, 5), "ddpcm is not defined for tiles of 5 x 5"),
        ((Codec.DDPCM, 4, 0), "granularity of 0 bits"),
    ],
)
def test_undefined_codecs_are_refused(arguments, what):
    with pytest.raises(ArchsimError, match=what):
        make_codec(*arguments)
