"""Which photos are worth using, before anything is known about where they were taken."""
