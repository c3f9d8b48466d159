"""Sampler ``owen_sobol``: a progressive low-discrepancy sequence, keyed by pixel and sample index.

Every pixel owns an infinite sequence of points. Each pair of dimensions is the (0, 2)-sequence of Sobol, in an order
of its own (see ``pairings.py``). Its digits are scrambled after Owen by hashes of (seed, pixel, pair): B. Burley,
"Practical Hash-based Owen Scrambling", JCGT 9(4), 2020. The hash that replaces the random permutation tree is that of
Laine and Karras with the constants of N. Vegdahl ("Building a Better LK Hash", 2021).

A sample is a pure function of (seed, pixel, sample index, dimension), never of its lane: chunk size, order of rounds
and number of threads cannot change it, and any prefix of a power-of-two length is a net.

Above 2^32 samples ``mi.render`` itself splits a picture into passes, but does not tell a Python sampler how many
samples a pixel has in each pass: the picture is right, but less well stratified.

.. pluginparameters::

 * - sample_count
   - |int|
   - Samples per pixel under ``mi.render``; need not be a power of two, though one is best. (Default: 4)
 * - seed
   - |int|
   - Added to the seed that ``mi.render`` passes. (Default: 0)

.. tabs::
    .. code-tab:: xml

        <sampler type="owen_sobol"><integer name="sample_count" value="64"/></sampler>

    .. code-tab:: python

        {'type': 'owen_sobol', 'sample_count': 64}
"""

from __future__ import annotations

from collections.abc import Sequence

import drjit as dr
import mitsuba as mi

from tracer.core.hashing import GOLDEN_RATIO, mix

from .pairings import DEGREE, POLYNOMIALS

SHUFFLE_KEY = 0x5BF1E
"""Arbitrary constant that makes the hash for the order of cycles differ from the hashes for scrambles of dimensions."""


def scramble_reversed(x: mi.UInt32, seed: mi.UInt32) -> mi.UInt32:
    """Return the Owen scramble of a number whose bits are reversed (every bit depends on lower bits only)."""
    x = x ^ (x * 0x3D20ADEA)
    x = x + seed
    x = x * ((seed >> 16) | 1)
    x = x ^ (x * 0x05526C56)
    return x ^ (x * 0x53A22864)


def pascal(x: mi.UInt32) -> mi.UInt32:
    """Return Pascal's triangle mod 2 times the bit vector ``x``: bit-reversed, the second Sobol dimension of index x.

    Bit j of the result is the sum of bits i >= j of ``x`` with binomial(i, j) odd. The matrix is a Kronecker power of
    [[1, 1], [0, 1]], hence five butterfly steps instead of 32 rows.
    """
    x = x ^ ((x >> 1) & 0x55555555)
    x = x ^ ((x >> 2) & 0x33333333)
    x = x ^ ((x >> 4) & 0x0F0F0F0F)
    x = x ^ ((x >> 8) & 0x00FF00FF)
    return x ^ (x >> 16)


def entry(table: Sequence[int], number: mi.UInt32) -> mi.UInt32:
    """Return entry ``number`` of a short table of constants; for a number beyond its end, an unspecified entry.

    It is found by a tree of selections, because an array to gather from would have to be made while a frozen function
    is being recorded.
    """
    entries = [mi.UInt32(value) for value in table]
    bit = 0
    while len(entries) > 1:
        odd = (number >> bit) & 1 == 1
        pairs = zip(entries[::2], [*entries[1::2], entries[-1]][: len(entries[::2])], strict=True)
        entries = [dr.select(odd, second, first) for first, second in pairs]
        bit += 1
    return entries[0]


def reorder(index: mi.UInt32, pair: mi.UInt32) -> mi.UInt32:
    """Return the place in the Sobol sequence from which a pair of dimensions takes the point of sample ``index``.

    It is the carry-less product of the index with the pair's polynomial in the shift to lower bits (``pairings.py``).
    """
    polynomial = entry(POLYNOMIALS, pair)
    place = index
    for k in range(1, DEGREE):
        place = place ^ dr.select((polynomial >> k) & 1 == 1, index >> k, 0)
    return place


def to_unit_interval(x: mi.UInt32) -> mi.Float:
    """Map 32 bits to [0, 1), using the 24 leading bits, which a float32 holds exactly."""
    return mi.Float(x >> 8) * (1.0 / (1 << 24))


class OwenSobolSampler(mi.Sampler):
    """See the documentation of this file."""

    def __init__(self, props: mi.Properties) -> None:
        sample_count = props.get("sample_count", 4)
        if sample_count < 1:
            raise ValueError(f'owen_sobol: "sample_count" must be at least 1 (was {sample_count})')
        super().__init__(props)
        super().set_sample_count(sample_count)
        self.base_seed = int(props.get("seed", 0))
        self.key = mi.UInt32(0)
        self.index = mi.UInt32(0)
        self.dimension = mi.UInt32(0)

    def seed(self, seed: mi.UInt32, wavefront_size: int = 0xFFFFFFFF) -> None:
        """Key the lanes the way Mitsuba's integrators lay them out: all samples of a pixel, then the next pixel."""
        if wavefront_size == 0xFFFFFFFF:
            wavefront_size = self.wavefront_size()
        super().seed(seed, wavefront_size)
        lane = dr.arange(mi.UInt32, wavefront_size)
        spp = dr.opaque(mi.UInt32, self.sample_count())
        pixel = lane // spp
        self.seed_samples(seed, pixel, lane - pixel * spp)

    def seed_samples(self, seed: mi.UInt32, pixel: mi.UInt32, index: mi.UInt32) -> None:
        """Key each lane by hand: sample ``index`` of pixel ``pixel`` (arrays of one width), at dimension 0."""
        root = mix(mi.UInt32(seed) + (GOLDEN_RATIO * (1 + self.base_seed)) % 2**32)
        dr.make_opaque(root)  # a literal would be compiled into the kernel, so that every seed had a kernel of its own
        self.key = mix(mix(mi.UInt32(pixel) + GOLDEN_RATIO) ^ root)
        self.index = dr.brev(mi.UInt32(index))
        self.dimension = dr.zeros(mi.UInt32, dr.width(self.index))

    def next_place(self) -> tuple[mi.UInt32, mi.UInt32]:
        """Return the place in the sequence and the hash for the current dimension or pair, and step to the next one."""
        hashed = mix(self.key ^ (self.dimension * GOLDEN_RATIO))
        cycle = self.dimension // len(POLYNOMIALS)
        # When all polynomials are used up, a new cycle uses them again, with the order of points shuffled at random.
        shuffled = scramble_reversed(self.index, mix(self.key ^ (cycle * GOLDEN_RATIO) ^ SHUFFLE_KEY))
        index = dr.brev(dr.select(cycle == 0, self.index, shuffled))
        place = reorder(index, self.dimension - cycle * len(POLYNOMIALS))
        self.dimension = self.dimension + 1
        return place, hashed

    def next_1d(self, active: mi.Bool = True) -> mi.Float:
        place, hashed = self.next_place()
        return to_unit_interval(dr.brev(scramble_reversed(place, mix(hashed))))

    def next_2d(self, active: mi.Bool = True) -> mi.Point2f:
        place, hashed = self.next_place()
        hash_x = mix(hashed)
        hash_y = mix(hash_x)
        x = dr.brev(scramble_reversed(place, hash_x))
        y = dr.brev(scramble_reversed(pascal(place), hash_y))
        return mi.Point2f(to_unit_interval(x), to_unit_interval(y))

    def clone(self) -> OwenSobolSampler:
        duplicate = self.fork()
        duplicate.key = mi.UInt32(self.key)
        duplicate.index = mi.UInt32(self.index)
        duplicate.dimension = mi.UInt32(self.dimension)
        return duplicate

    def fork(self) -> OwenSobolSampler:
        properties = mi.Properties("owen_sobol")
        properties["sample_count"] = self.sample_count()
        properties["seed"] = self.base_seed
        return type(self)(properties)

    def advance(self) -> None:
        # A second pass of the same lanes must not repeat the first: continue the sequence of every pixel.
        spp = dr.opaque(mi.UInt32, self.sample_count())
        self.index = dr.brev(dr.brev(self.index) + spp)
        self.dimension = dr.zeros(mi.UInt32, dr.width(self.index))

    def schedule_state(self) -> None:
        dr.schedule(self.key, self.index, self.dimension)

    def traverse(self, callback: mi.TraversalCallback) -> None:
        super().traverse(callback)

    def to_string(self) -> str:
        return f"OwenSobolSampler[\n  sample_count = {self.sample_count()},\n  seed = {self.base_seed}\n]"


mi.register_sampler("owen_sobol", OwenSobolSampler)
