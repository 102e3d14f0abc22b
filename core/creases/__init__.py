"""What is known of creases: those that are drawn or painted, where they end, their angles, the crease pattern."""
