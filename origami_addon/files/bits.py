"""Reads the headers of coded pictures bit by bit."""

from __future__ import annotations

_LONGEST_CODE = 32


class Bits:
    """The bits of some bytes, read one after the other.

    Parameters
    ----------
    content : bytes

    Attributes
    ----------
    text : str
        All bits as 0 and 1.
    at : int
        The next one.
    """

    def __init__(self, content: bytes) -> None:
        self.text = "".join(f"{byte:08b}" for byte in content)
        self.at = 0

    def number(self, count: int) -> int:
        """The next ``count`` bits as a number.

        Raises
        ------
        IndexError
            If there are fewer.
        """
        if self.at + count > len(self.text):
            raise IndexError("behind the last bit")
        self.at += count
        return int(self.text[self.at - count : self.at] or "0", 2)

    def exponential(self) -> int:
        """The next number in an exponential Golomb code.

        Raises
        ------
        IndexError
            If there is none.
        """
        zeros = self.text[self.at : self.at + _LONGEST_CODE].find("1")
        if zeros < 0:
            raise IndexError("not a code")
        self.at += zeros
        return self.number(zeros + 1) - 1
