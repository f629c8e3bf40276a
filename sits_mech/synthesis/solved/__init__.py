"""What a design is worth: its loads solved, its figures of merit with their errors."""
