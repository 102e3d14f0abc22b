"""The science: numpy and scipy, arrays in, arrays out."""
