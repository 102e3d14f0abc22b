"""Whether the photos were placed rightly, and if not, the likeliest cause."""
