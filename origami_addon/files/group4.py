"""Bitmaps packed as CCITT Group 4 (ITU-T Recommendation T.6), the form of black and white in TIFF and PDF.

Each row is coded by how its changes between white and black differ from those of the row above. The rows above are
known beforehand, so all rows of a band are coded side by side: one pass gives each row its next code word.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_BAND = 1 << 22  # pixels coded side by side

# Code words of runs of white and of black, as digits: lengths 0 to 63, then multiples of 64 up to 1728 (T.4, tables 2
# and 3).
_WHITE = """
00110101 000111 0111 1000 1011 1100 1110 1111 10011 10100 00111 01000 001000 000011 110100 110101
101010 101011 0100111 0001100 0001000 0010111 0000011 0000100 0101000 0101011 0010011 0100100 0011000 00000010 00000011
00011010 00011011 00010010 00010011 00010100 00010101 00010110 00010111 00101000 00101001 00101010 00101011 00101100
00101101 00000100 00000101 00001010 00001011 01010010 01010011 01010100 01010101 00100100 00100101 01011000 01011001
01011010 01011011 01001010 01001011 00110010 00110011 00110100
11011 10010 010111 0110111 00110110 00110111 01100100 01100101 01101000 01100111 011001100 011001101 011010010 011010011
011010100 011010101 011010110 011010111 011011000 011011001 011011010 011011011 010011000 010011001 010011010 011000
010011011
"""
_BLACK = """
0000110111 010 11 10 011 0011 0010 00011 000101 000100 0000100 0000101 0000111 00000100 00000111 000011000
0000010111 0000011000 0000001000 00001100111 00001101000 00001101100 00000110111 00000101000 00000010111 00000011000
000011001010 000011001011 000011001100 000011001101 000001101000 000001101001 000001101010 000001101011 000011010010
000011010011 000011010100 000011010101 000011010110 000011010111 000001101100 000001101101 000011011010 000011011011
000001010100 000001010101 000001010110 000001010111 000001100100 000001100101 000001010010 000001010011 000000100100
000000110111 000000111000 000000100111 000000101000 000001011000 000001011001 000000101011 000000101100 000001011010
000001100110 000001100111
0000001111 000011001000 000011001001 000001011011 000000110011 000000110100 000000110101 0000001101100 0000001101101
0000001001010 0000001001011 0000001001100 0000001001101 0000001110010 0000001110011 0000001110100 0000001110101
0000001110110 0000001110111 0000001010010 0000001010011 0000001010100 0000001010101 0000001011010 0000001011011
0000001100100 0000001100101
"""
# Of both colours, multiples of 64 from 1792 to 2560.
_LONG = """
00000001000 00000001100 00000001101 000000010010 000000010011 000000010100 000000010101 000000010110 000000010111
000000011100 000000011101 000000011110 000000011111
"""
_LONGEST = 2560
_PASS, _HORIZONTAL = "0001", "001"
# By the place of a change less that of the change above, from -3 to 3.
_VERTICAL = ("0000010", "000010", "010", "1", "011", "000011", "0000011")
_END = "000000000001" * 2

_Words = tuple[NDArray[np.uint32], NDArray[np.uint8]]


def group4(ink: NDArray[np.bool_]) -> bytes:
    """A bitmap as Group 4, with the mark of its end.

    Parameters
    ----------
    ink : (H, W) bool array
        True for black; at least one pixel.
    """
    height, width = ink.shape
    rows = max(1, _BAND // width)
    packed, rest = [], np.zeros(0, np.uint8)
    for top in range(0, height, rows):
        above = ink[top - 1] if top else np.zeros(width, bool)
        bits = np.concatenate([rest, _band(ink[top : top + rows], above)])
        whole = len(bits) // 8 * 8
        packed.append(np.packbits(bits[:whole]).tobytes())
        rest = bits[whole:]
    end = np.array([int(digit) for digit in _END], np.uint8)
    return b"".join([*packed, np.packbits(np.concatenate([rest, end])).tobytes()])


def _band(ink: NDArray[np.bool_], above: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """The bits of rows below a row that is already coded."""
    height, width = ink.shape
    changes, first = _changes(np.concatenate([above[None], ink]))
    stride = 2 * width + 4  # between the changes of a row and the next row's, at which the search goes on
    keys = changes + np.repeat(np.arange(height + 1), np.diff(first)) * stride
    coded = _Coded()
    row = np.arange(height)  # the rows that are not yet whole
    here = np.full(height, -1)  # the place up to which each of them is coded
    ours = first[1:-1].copy()  # the first change beyond it
    while len(row):
        black = (ours - first[row + 1]) & 1
        theirs = np.searchsorted(keys, row * stride + here, side="right")
        theirs += (theirs - first[row] + black) & 1  # to the same colour as ours
        theirs = np.minimum(theirs, first[row + 1] - 1)
        one, two = changes[ours], changes[np.minimum(ours + 1, first[row + 2] - 1)]
        one_above, two_above = changes[theirs], changes[np.minimum(theirs + 1, first[row + 1] - 1)]
        passing = two_above < one
        vertical = ~passing & (np.abs(one - one_above) <= 3)
        horizontal = ~passing & ~vertical
        coded.add(row[passing], _PASS_WORD, 0)
        coded.add(row[vertical], _VERTICAL_WORDS, (one - one_above)[vertical] + 3)
        coded.add(row[horizontal], _HORIZONTAL_WORD, 0)
        coded.add_runs(row[horizontal], (one - np.maximum(here, 0))[horizontal], black[horizontal])
        coded.add_runs(row[horizontal], (two - one)[horizontal], 1 - black[horizontal])
        here = np.where(passing, two_above, np.where(vertical, one, two))
        ours = np.where(passing, ours, np.where(vertical, ours + 1, ours + 2))
        left = here < width
        row, here, ours = row[left], here[left], np.minimum(ours, first[row + 2] - 1)[left]
    return coded.bits()


def _changes(ink: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The columns at which the colour changes, of all rows one after the other, and where each row begins among them.

    A row begins white and ends with four changes at its width, which searches for one more change find.
    """
    height, width = ink.shape
    before = np.concatenate([np.zeros((height, 1), bool), ink[:, :-1]], axis=1)
    rows, columns = np.nonzero(ink != before)
    found = np.bincount(rows, minlength=height)
    first = np.concatenate([[0], np.cumsum(found + 4)])
    changes = np.full(first[-1], width)
    changes[np.arange(len(columns)) + 4 * rows] = columns
    return changes, first


class _Coded:
    """Code words of rows, in the order in which each row gets them."""

    def __init__(self) -> None:
        self._rows: list[NDArray[np.int64]] = []
        self._words: list[_Words] = []

    def add(self, rows: NDArray[np.int64], words: _Words, index: NDArray[np.int64] | int) -> None:
        """Give each of these rows the word of an index."""
        if len(rows):
            self._rows.append(rows)
            index = np.broadcast_to(index, len(rows))
            self._words.append((words[0][index], words[1][index]))

    def add_runs(self, rows: NDArray[np.int64], lengths: NDArray[np.int64], black: NDArray[np.int64]) -> None:
        """Give each of these rows the words of a run."""
        while len(long := np.flatnonzero(lengths >= _LONGEST)):
            self.add(rows[long], _RUN_WORDS, black[long] * _RUNS_OF_COLOR + 64 + _LONGEST // 64 - 1)
            lengths = np.where(lengths >= _LONGEST, lengths - _LONGEST, lengths)
        more = np.flatnonzero(lengths >= 64)
        self.add(rows[more], _RUN_WORDS, black[more] * _RUNS_OF_COLOR + 64 + lengths[more] // 64 - 1)
        self.add(rows, _RUN_WORDS, black * _RUNS_OF_COLOR + lengths % 64)

    def bits(self) -> NDArray[np.uint8]:
        """The words of the first row, then those of the next, bit by bit."""
        order = np.argsort(np.concatenate(self._rows).astype(np.uint32), kind="stable")
        words, lengths = (np.concatenate(parts)[order] for parts in zip(*self._words, strict=True))
        lengths = lengths.astype(np.int64)
        left = np.repeat(np.cumsum(lengths), lengths) - np.arange(lengths.sum()) - 1
        return (np.repeat(words, lengths) >> left.astype(np.uint32) & 1).astype(np.uint8)


def _words(*digits: str) -> _Words:
    return np.array([int(each, 2) for each in digits], np.uint32), np.array([len(each) for each in digits], np.uint8)


_PASS_WORD, _HORIZONTAL_WORD, _VERTICAL_WORDS = _words(_PASS), _words(_HORIZONTAL), _words(*_VERTICAL)
_RUN_WORDS = _words(*_WHITE.split(), *_LONG.split(), *_BLACK.split(), *_LONG.split())
_RUNS_OF_COLOR = len(_RUN_WORDS[0]) // 2
