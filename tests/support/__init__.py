"""What several tests share: measurements of the structure, models built by hand, and small programs."""
