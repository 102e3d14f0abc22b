"""What AV1 pictures say of their size.

Source: AV1 Bitstream & Decoding Process Specification, 5.3 (units) and 5.5 (sequence header).
"""

from __future__ import annotations

from collections.abc import Iterator

from .bits import Bits

_SEQUENCE_HEADER = 1
_PICTURES = (3, 6)  # kinds of units
_TIERED_LEVEL = 7


def sizes(configuration: bytes, coded: bytes) -> set[tuple[int, int]]:
    """Largest width and height according to each sequence header.

    Parameters
    ----------
    configuration : bytes
        Content of the `av1C` box.
    coded : bytes
        The picture.

    Raises
    ------
    IndexError
        If something is damaged or missing.
    """
    units = list(_units(coded))
    headers = [content for kind, content in [*_units(configuration[4:]), *units] if kind == _SEQUENCE_HEADER]
    if not headers or not any(kind in _PICTURES for kind, _ in units):
        raise IndexError("no picture")
    return {_size(Bits(header[:64])) for header in headers}


def is_deep(configuration: bytes) -> bool:
    """Whether the pictures have more than 8 bits for each colour."""
    return configuration[2] & 0x40 > 0


def _units(coded: bytes) -> Iterator[tuple[int, bytes]]:
    """Kind and content of each unit."""
    at = 0
    while at < len(coded):
        head = coded[at]
        at += 2 if head & 4 else 1
        size = len(coded) - at
        if head & 2:  # the size follows, seven bits in each byte
            size = 0
            for place in range(8):
                byte = coded[at]
                at += 1
                size |= (byte & 127) << 7 * place
                if byte < 128:
                    break
        if at + size > len(coded):
            raise IndexError("behind the last unit")
        yield head >> 3 & 15, coded[at : at + size]
        at += size


def _size(bits: Bits) -> tuple[int, int]:
    bits.number(4)
    if bits.number(1):  # the short header of a still picture
        bits.number(5)
    else:
        decoder_model, delay_bits = False, 0
        if bits.number(1):  # timing
            bits.number(64)
            if bits.number(1):
                bits.exponential()
            decoder_model = bool(bits.number(1))
            if decoder_model:
                delay_bits = bits.number(5) + 1
                bits.number(42)
        delay = bits.number(1)
        for _ in range(bits.number(5) + 1):
            bits.number(12)
            if bits.number(5) > _TIERED_LEVEL:
                bits.number(1)
            if decoder_model and bits.number(1):
                bits.number(2 * delay_bits + 1)
            if delay and bits.number(1):
                bits.number(4)
    width_bits, height_bits = bits.number(4) + 1, bits.number(4) + 1
    return bits.number(width_bits) + 1, bits.number(height_bits) + 1
