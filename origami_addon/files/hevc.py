"""What HEVC pictures say of their size and colours, and how to change the latter.

Source: ITU-T H.265: 7.3.1 (units), 7.3.2.2 (sequence parameter set) and E.2.1 (video usability information).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from .bits import Bits
from .heif_colour import Colour

_PARAMETER_SET = 33
_NEVER_INSIDE = (b"\0\0\0", b"\0\0\1", b"\0\0\2")
_PICTURES = range(32)  # kinds of units
# Pixels for each sample of colour, by chroma_format_idc.
_SUBSAMPLING = {0: (1, 1), 1: (2, 2), 2: (2, 1), 3: (1, 1)}


@dataclass(frozen=True)
class _Found:
    """What a sequence parameter set holds: the picture's size, and the bit at which usability information begins."""

    size: tuple[int, int]
    usability: int | None


def sizes(configuration: bytes, coded: bytes) -> set[tuple[int, int]]:
    """Width and height according to each sequence parameter set, those for the decoder and those inside the picture.

    Parameters
    ----------
    configuration : bytes
        Content of the `hvcC` box.
    coded : bytes
        The picture.

    Raises
    ------
    IndexError, KeyError
        If something is damaged or missing.
    """
    sets = [configuration[start:end] for start, end in _parameter_sets(configuration)]
    units = list(_units(configuration, coded))
    sets += [unit for unit in units if _kind(unit) == _PARAMETER_SET]
    if not any(_kind(unit) in _PICTURES for unit in units) or not sets:
        raise IndexError("no picture")
    return {_read(Bits(_payload(each))).size for each in sets}


def is_deep(configuration: bytes) -> bool:
    """Whether the pictures have more than 8 bits for each colour."""
    return configuration[17] & 7 > 0


def with_colour(configuration: bytes, colour: Colour) -> bytes:
    """The content of an `hvcC` box whose parameter sets name the given matrix and range.

    A file's `nclx` property overrides what its pictures say themselves, but Blender's decoder only reads the latter.

    Raises
    ------
    IndexError, KeyError
        If it is damaged.
    """
    for start, end in reversed(list(_parameter_sets(configuration))):
        changed = _with_colour(configuration[start:end], colour)
        configuration = configuration[: start - 2] + len(changed).to_bytes(2, "big") + changed + configuration[end:]
    return configuration


def _parameter_sets(configuration: bytes) -> Iterator[tuple[int, int]]:
    """Start and end of each sequence parameter set in the content of an `hvcC` box."""
    at = 23
    for _ in range(configuration[22]):
        kind = configuration[at] & 63
        count = int.from_bytes(configuration[at + 1 : at + 3], "big")
        at += 3
        for _ in range(count):
            end = at + 2 + int.from_bytes(configuration[at : at + 2], "big")
            if end > len(configuration):
                raise IndexError("behind the last set")
            if kind == _PARAMETER_SET:
                yield at + 2, end
            at = end


def _units(configuration: bytes, coded: bytes) -> Iterator[bytes]:
    """The units of a coded picture, which fill it."""
    length_size = (configuration[21] & 3) + 1
    at = 0
    while at < len(coded):
        start = at + length_size
        at = start + int.from_bytes(coded[at:start], "big")
        unit = coded[start:at]
        if len(unit) < 2 or at > len(coded):
            raise IndexError("behind the last unit")
        # Where a disk has lost a part of a file, there are zeros.
        if any(code in unit.rstrip(b"\0") for code in _NEVER_INSIDE):
            raise IndexError("a start code inside a unit")
        yield unit


def _kind(unit: bytes) -> int:
    return unit[0] >> 1 & 63


def _payload(unit: bytes) -> bytes:
    """The unit without its two bytes of header, and without the bytes that keep start codes out of it."""
    return unit[2:].replace(b"\0\0\3", b"\0\0")


def _unit(header: bytes, payload: bytes) -> bytes:
    escaped, zeros = bytearray(header), 0
    for byte in payload:
        if zeros >= 2 and byte <= 3:
            escaped.append(3)
            zeros = 0
        escaped.append(byte)
        zeros = zeros + 1 if byte == 0 else 0
    return bytes(escaped)


def _with_colour(unit: bytes, colour: Colour) -> bytes:
    bits = Bits(_payload(unit))
    usability = _read(bits).usability
    if usability is None:
        return unit
    bits.at = usability
    signal = f"1101{colour.full_range:b}1{colour.primaries:08b}{colour.transfer:08b}{colour.matrix:08b}"
    if not bits.number(1):
        # Neither the shape of pixels nor overscan before it, and nothing behind it.
        text = f"{bits.text[:usability]}100{signal}{'0' * 7}{bits.text[bits.at :]}"
    else:
        if bits.number(1) and bits.number(8) == 255:  # the shape of pixels as two numbers
            bits.number(32)
        if bits.number(1):  # overscan
            bits.number(1)
        start = bits.at
        if bits.number(1):
            bits.number(4)
            if bits.number(1):
                bits.number(24)
        text = bits.text[:start] + signal + bits.text[bits.at :]
    text = text.rstrip("0")
    text += "0" * (-len(text) % 8)
    return _unit(unit[:2], int(text, 2).to_bytes(len(text) // 8, "big"))


def _read(bits: Bits) -> _Found:
    bits.number(4)
    layers = bits.number(3)
    bits.number(1)
    _skip_profile(bits, layers)
    bits.exponential()
    chroma = bits.exponential()
    if chroma == 3:
        bits.number(1)
    width, height = bits.exponential(), bits.exponential()
    if bits.number(1):
        left, right, top, bottom = (bits.exponential() for _ in range(4))
        across, down = _SUBSAMPLING[chroma]
        width, height = width - across * (left + right), height - down * (top + bottom)
    bits.exponential(), bits.exponential()  # bits per sample
    order_bits = bits.exponential() + 4
    for _ in range(layers + 1 if bits.number(1) else 1):
        for _ in range(3):
            bits.exponential()
    for _ in range(6):  # sizes of blocks
        bits.exponential()
    if bits.number(1) and bits.number(1):
        _skip_scaling_lists(bits)
    bits.number(2)
    if bits.number(1):  # pulse code modulation
        bits.number(8)
        bits.exponential(), bits.exponential()
        bits.number(1)
    if bits.exponential():  # sets of reference pictures, which a photo does not need
        return _Found((width, height), None)
    if bits.number(1):
        for _ in range(bits.exponential()):
            bits.number(order_bits + 1)
    bits.number(2)
    return _Found((width, height), bits.at)


def _skip_profile(bits: Bits, layers: int) -> None:
    bits.number(88 + 8)
    present = [(bits.number(1), bits.number(1)) for _ in range(layers)]
    if layers:
        bits.number(2 * (8 - layers))
    for profile, level in present:
        bits.number(88 * profile + 8 * level)


def _skip_scaling_lists(bits: Bits) -> None:
    for size in range(4):
        for _ in range(6 if size < 3 else 2):
            if not bits.number(1):
                bits.exponential()
                continue
            for _ in range(min(64, 4 << 2 * size) + (size > 1)):
                bits.exponential()
